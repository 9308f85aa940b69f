// export/export_mesh.h: the job that writes one level of a store, or some patches of it, to a mesh
// file as a stream. For any level, the job needs only the memory of its budget and a few buffers.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "export/patch_selection.h"
#include "plait/bounds.h"
#include "plait/detail/namespace.h"
#include "plait/existing.h"
#include "plait/extend/backend_registry.h"
#include "plait/job.h"
#include "plait/options.h"

PLAIT_BEGIN_NAMESPACE

struct ExportRequest {
  std::filesystem::path store;
  /// NAME.(ply|obj|stl|off)[.gz|.zst] or NAME.(vtp|pvtp|glb|gltf): the name says the format.
  std::filesystem::path output;
  int level = -1;  ///< counted from the user's mesh; -1: the finest
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
  /// glTF: what the numbers of "color" are: "srgb", which the file gets as linear numbers, as glTF
  /// has them; "linear"; empty: sRGB if they are integers, else linear.
  std::string colors = {};
  std::string up = "y";  ///< glTF: the axis of the store that points upwards, "y" or "z"
  bool narrow = false;   ///< glTF: attributes of float64 are written as float32
  Existing existing = Existing::kRefuse;
  std::uint64_t budget_bytes = OpenOptions().budget_bytes;
};

/// What the numbers of a file moved.
struct Moved {
  double most = 0;          ///< the most that a coordinate was moved by
  std::uint64_t count = 0;  ///< vertices of the file, or triangles where it has no vertices
};

struct ExportResult {
  std::filesystem::path file;  ///< the main file
  int level = 0;
  std::uint64_t vertices = 0, triangles = 0, file_bytes = 0;
  std::uint64_t patches = 0;
  Moved moved;
  /// Normals of OBJ and glTF files at the creases of a store (export/crease_normals.h), which are
  /// those of the triangles on one side.
  std::uint64_t side_normals = 0;
  /// The attributes of the level, and of the base faces, that the file does not have.
  std::vector<std::string> left_out = {};
};

/// Writes all vertices first (base vertices, then level by level in slot order), then the
/// triangles, face by face in layout order. Triangles have the orientation of the base mesh. For a
/// level that is not the finest, vertices have the positions that the finest level gives them.
///   PLY: binary little-endian, x y z as float or double, list uchar int (uint from 2^31 vertices).
///   OBJ, OFF: text that reads back to the same numbers.   STL: binary, float32, facets.
///   VTK: .vtp with raw appended data; .pvtp with one .vtp for each stretch of faces beside it.
///   glTF: groups of patches as primitives, which share one accessor of indices. A vertex on the
///   border of two patches is in both, with the same bits. .gltf has its numbers in a .bin beside
///   it. Positions of float64, and quantized ones, are relative to the translation of the node.
///   Normals have the length 1; if one has no direction, the file has none, and `warn` says so.
/// At the creases of a store, OBJ and glTF files have a normal for each side. Other files, and
/// stores whose faces have depths of their own, have one for each vertex, and `warn` says so.
/// Progress counts vertices and triangles. After an error no file is left. Removes left-overs of
/// killed runs with the same output. Errors: those of Store::open and of UnpublishedFile;
/// kInvalidArgument for a name of no known format, for a level, a face or an attribute that the
/// store does not have, for a box that no patch meets, for an attribute that the format cannot
/// hold, for a file that exists without `replace`, and for more vertices, facets or bytes than the
/// format can count; kCancelled; kIo, kNoSpace, kCorruption. Pinned by tests/tools/export_test.cpp
/// and tests/tools/export_readers_test.py.
ExportResult export_mesh(const ExportRequest& request, const BackendRegistry& backends,
                         const JobWatch& watch = {});

PLAIT_END_NAMESPACE
