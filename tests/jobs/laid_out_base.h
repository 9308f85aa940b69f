// What plait layout makes of a mesh, for tests.
#pragma once

#include <filesystem>
#include <utility>

#include "format/base_index_file.h"
#include "format/base_mesh_file.h"
#include "format/file_names.h"
#include "layout/base_directory.h"
#include "plait/layout.h"

namespace plait::test {

/// Writes it, and returns the mesh in memory.
inline BaseMesh laid_out_at(const std::filesystem::path& path, IndexedMesh mesh) {
  BaseMesh base = lay_out(BaseMesh::build(std::move(mesh)), LayoutKind::kHilbert).mesh;
  std::filesystem::create_directory(path);
  const Directory directory(path);
  const StoredSize size = write_base_mesh_file(directory, base);
  write_base_index_file(directory, kBaseIndexName, base, size.checksum, false);
  write_base_directory(
      directory,
      {base.vertex_count(), base.edge_count(), base.face_count(), base.border_edge_count()}, size);
  return base;
}

}  // namespace plait::test
