// export/mesh_export.h: one level of a store as a mesh file, streamed: memory is the store's budget
// and a few buffers, whatever the level.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "export/output_stream.h"
#include "plait/store.h"

namespace plait {

enum class MeshFormat : std::uint8_t { kPly, kObj, kStl };

struct ExportFormat {
  MeshFormat mesh = MeshFormat::kPly;
  Compression compression = Compression::kNone;
};
/// From NAME.(ply|obj|stl)[.gz|.zst]. Errors: kInvalidArgument naming the endings there are.
ExportFormat export_format(const std::filesystem::path& path);

struct ExportOptions {
  ExportFormat format;
  int level = 0;  ///< counted from the mesh the user gave
  /// Beside the position: "normal" becomes nx ny nz (vn in OBJ); others PLY properties NAME or
  /// NAME_0, NAME_1 ...
  std::vector<std::string> attributes;
  /// Work is counted in vertices and triangles; false cancels.
  std::function<bool(std::uint64_t done, std::uint64_t total)> proceed;
};

struct ExportResult {
  std::uint64_t vertices = 0, triangles = 0, file_bytes = 0;
};

/// Vertices come first (base vertices, then by level in slot order), triangles after them, face by
/// face in layout order, oriented as the base mesh is. At a coarser level than the finest its
/// vertices are where the finest level has them.
///   PLY: binary little-endian, x y z as float or double, list uchar int (uint from 2^31 vertices).
///   OBJ: text that reads back to the same numbers.   STL: binary, float32, facets.
/// Errors: kInvalidArgument for a level or an attribute that is not there or that the format
/// cannot take, and for more vertices or facets than the format can count (2^32 in PLY and STL);
/// kCancelled; kIo, kNoSpace, kCorruption.
/// Pinned by tests/tools/export_test.cpp.
/// `file` is empty, and stays open.
ExportResult export_mesh(Store& store, File& file, const ExportOptions& options);

}  // namespace plait
