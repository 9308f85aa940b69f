// export/mesh_export.h: writes one level of a store to a mesh file as a stream. For any level, the
// export needs only the memory of the store's budget and a few buffers.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "export/output_stream.h"
#include "plait/progress.h"
#include "plait/store.h"

namespace plait {

enum class MeshFormat : std::uint8_t { kPly, kObj, kStl };

struct ExportFormat {
  MeshFormat mesh = MeshFormat::kPly;
  StreamCompression compression = StreamCompression::kNone;
};
/// The format that a name NAME.(ply|obj|stl)[.gz|.zst] stands for.
/// Errors: kInvalidArgument; the message lists the known endings.
ExportFormat export_format(const std::filesystem::path& path);

struct ExportOptions {
  ExportFormat format;
  int level = 0;  ///< counted from the user's mesh
  /// Attributes besides the position. "normal" becomes nx ny nz (vn in OBJ), "color" red green blue
  /// alpha, "texture" s t. Others become PLY properties NAME, or NAME_0, NAME_1 ...
  std::vector<std::string> attributes;
  /// Attributes of the base faces: each becomes a PLY property of the triangles.
  std::vector<std::string> face_attributes;
  /// Called with the number of vertices and triangles done. Returns false to cancel.
  ProgressCallback progress;
};

struct ExportResult {
  std::uint64_t vertices = 0, triangles = 0, file_bytes = 0;
};

/// Writes all vertices first (base vertices, then level by level in slot order), then the
/// triangles, face by face in layout order. Triangles have the orientation of the base mesh. For a
/// level that is not the finest, vertices have the positions that the finest level gives them.
///   PLY: binary little-endian, x y z as float or double, list uchar int (uint from 2^31 vertices).
///   OBJ: text that reads back to the same numbers.   STL: binary, float32, facets.
/// `file` must be open and empty; it stays open.
/// Errors: kInvalidArgument for a level or an attribute that the store does not have, for an
/// attribute that the format cannot hold, and for more vertices or facets than the format can count
/// (2^32 in PLY and STL); kCancelled; kIo, kNoSpace, kCorruption.
/// Pinned by tests/tools/export_test.cpp.
ExportResult export_mesh(Store& store, File& file, const ExportOptions& options);

}  // namespace plait
