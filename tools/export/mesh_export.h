// export/mesh_export.h: writes one level of a store, or some patches of it, to a mesh file as a
// stream. For any level, the export needs only the memory of the store's budget and a few buffers.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "export/mesh_format.h"
#include "export/output_files.h"
#include "plait/bounds.h"
#include "plait/progress.h"
#include "plait/store.h"

namespace plait {

/// Base faces in layout order, both ends included.
struct FaceRange {
  FaceId first = 0, last = 0;
};

struct ExportOptions {
  ExportFormat format;
  int level = 0;  ///< counted from the user's mesh
  /// Attributes besides the position. "normal" becomes nx ny nz (vn in OBJ, NORMAL in glTF),
  /// "color" red green blue alpha (COLOR_0), "texture" s t. Others become PLY properties NAME, or
  /// NAME_0, NAME_1 ..., arrays NAME of VTK, and accessors _NAME of glTF.
  std::vector<std::string> attributes;
  /// Attributes of the base faces: each becomes a PLY property or a VTK array of the triangles.
  std::vector<std::string> face_attributes;
  std::optional<Box> box;        ///< only the patches whose bounds meet the box
  std::vector<FaceRange> faces;  ///< only these patches; empty: all. With a box: those of both
  bool quantize = false;         ///< glTF: positions in 16 bits, normals in 8
  std::uint64_t pieces = 0;      ///< .pvtp: how many files; 0: one for 4 million triangles
  /// Called with the number of vertices and triangles done. Returns false to cancel.
  ProgressCallback progress;
};

struct ExportResult {
  std::uint64_t vertices = 0, triangles = 0, file_bytes = 0;
  std::uint64_t patches = 0;
  double position_error = 0;  ///< the most that a coordinate was moved by
};

/// What is known of a glTF file when it is written.
struct GltfOutcome {
  std::uint64_t vertices = 0, file_bytes = 0;
  double position_error = 0;
};

/// Writes all vertices first (base vertices, then level by level in slot order), then the
/// triangles, face by face in layout order. Triangles have the orientation of the base mesh. For a
/// level that is not the finest, vertices have the positions that the finest level gives them.
///   PLY: binary little-endian, x y z as float or double, list uchar int (uint from 2^31 vertices).
///   OBJ, OFF: text that reads back to the same numbers.   STL: binary, float32, facets.
///   VTK: .vtp with raw appended data; .pvtp with one .vtp for each stretch of faces beside it.
///   glTF: groups of patches as primitives, which share one accessor of indices. A vertex on the
///   border of two patches is in both, with the same bits. .gltf has its numbers in a .bin beside
///   it.
/// The files must be empty; the caller publishes them.
/// Errors: kInvalidArgument for a level, a face or an attribute that the store does not have, for a
/// box that no patch meets, for an attribute that the format cannot hold, and for more vertices,
/// facets or bytes than the format can count; kCancelled; kIo, kNoSpace, kCorruption.
/// Pinned by tests/tools/export_test.cpp and tests/python/export_test.py.
ExportResult export_mesh(Store& store, OutputFiles& files, const ExportOptions& options);

}  // namespace plait
