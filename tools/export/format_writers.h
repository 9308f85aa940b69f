// The writers of export_mesh, one for each format. export_mesh checks levels, attributes and counts
// before it calls a writer.
#pragma once

#include <cstdint>
#include <functional>
#include <span>

#include "export/mesh_export.h"
#include "export/numbered_triangles.h"
#include "export/output_stream.h"
#include "plait/error.h"

namespace plait {

struct ExportTask {
  Store& store;
  AttributeId position = 0;
  std::span<const AttributeId> extras;  ///< the attributes to write besides the position
  int level = 0;                        ///< counted from the user's mesh
  int refinements = 0;  ///< how often the store's base mesh is refined to give this level
  const VertexNumbering& numbering;
  OutputStream& output;
  /// Throws kCancelled.
  std::function<void(std::uint64_t done)> progress;
  std::span<const std::string> face_attributes;

  std::uint64_t vertices() const { return numbering.vertex_count(); }
  std::uint64_t triangles() const { return triangle_count(store.base(), refinements); }
};

void write_ply_level(const ExportTask& task);
void write_obj_level(const ExportTask& task);
void write_stl_level(const ExportTask& task);

/// Throws kInvalidArgument for an attribute that PLY cannot hold.
void check_ply_attribute(const AttributeSchema& schema);

}  // namespace plait
