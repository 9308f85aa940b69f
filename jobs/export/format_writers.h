// The writers of export_mesh(), one for each format. export_mesh() checks levels, attributes and
// counts before it calls a writer.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "export/crease_normals.h"
#include "export/export_mesh.h"
#include "export/mesh_format.h"
#include "export/numbered_triangles.h"
#include "export/output_files.h"
#include "export/output_stream.h"
#include "export/patch_selection.h"
#include "plait/detail/namespace.h"
#include "plait/store.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

struct ExportTask {
  Store& store;
  const ExportRequest& request;
  MeshFormat format;
  int level;  ///< that of the request, or the finest
  AttributeId position = 0;
  std::span<const AttributeId> extras;  ///< the attributes to write besides the position
  const PatchSelection& patches;
  /// Throws kCancelled. `done` counts vertices and triangles.
  std::function<void(std::uint64_t done)> progress;
  std::function<void(const std::string&)> warn;
  /// Null: "normal" is written as it is, or not at all.
  const CreaseNormals* creases = nullptr;

  std::uint64_t vertices() const { return patches.vertex_count(); }
  std::uint64_t triangles() const { return patches.triangle_count(); }
  const AttributeSchema& schema(AttributeId attribute) const {
    return store.attributes()[attribute].schema;
  }
};

/// What is known of a glTF file when it is written.
struct GltfOutcome {
  std::uint64_t vertices = 0, file_bytes = 0;
  Moved moved;
  bool without_normals = false;    ///< although they were asked for
  std::uint64_t side_normals = 0;  ///< at creases
};

void write_ply_level(const ExportTask& task, OutputStream& output);
/// Returns the number of normals of sides, at creases.
std::uint64_t write_obj_level(const ExportTask& task, OutputStream& output);
void write_off_level(const ExportTask& task, OutputStream& output);
/// Returns what the narrower numbers moved, in triangles.
Moved write_stl_level(const ExportTask& task, OutputStream& output);
void write_vtp_level(const ExportTask& task, OutputStream& output);
/// Writes one .vtp file for each piece beside the main file, and returns the bytes of all files.
std::uint64_t write_pvtp_level(const ExportTask& task, OutputFiles& files);
/// Writes .glb, or .gltf with a .bin beside it.
GltfOutcome write_gltf_level(const ExportTask& task, OutputFiles& files);

/// Whether indices below `count` fit in the smaller of the two types that files have for them.
constexpr bool fits_31_bits(std::uint64_t count) noexcept { return count <= 0x7fffffff; }

/// An attribute of the base faces.
struct FaceColumn {
  AttributeSchema schema;
  std::span<const std::byte> numbers;
};
std::vector<FaceColumn> face_columns(const ExportTask& task);

PLAIT_END_NAMESPACE
