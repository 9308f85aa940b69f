// The writers behind export_mesh, one for each format. Checks are done before they are called.
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
  std::span<const AttributeId> extras;  ///< beside the position
  int level = 0;                        ///< counted from the mesh the user gave
  int refinements = 0;                  ///< how often the store's base mesh is refined for it
  const VertexNumbering& numbering;
  OutputStream& output;
  /// Throws kCancelled.
  std::function<void(std::uint64_t done)> progress;

  std::uint64_t vertices() const { return numbering.vertex_count(); }
  std::uint64_t triangles() const { return triangle_count(store.base(), refinements); }
};

void write_ply_level(const ExportTask& task);
void write_obj_level(const ExportTask& task);
void write_stl_level(const ExportTask& task);

/// What a format cannot hold. Errors: kInvalidArgument.
void check_ply_attribute(const AttributeSchema& schema);

}  // namespace plait
