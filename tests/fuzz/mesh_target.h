// tests/fuzz/mesh_target.h: the common part of the targets for mesh readers. BaseMesh either
// accepts the mesh of a reader or refuses it with a named error. The arrays of an accepted mesh
// satisfy all their relations.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "memory_file.h"
#include "mesh/files/input.h"
#include "mesh/files/readers.h"
#include "oracle.h"
#include "plait/base_mesh.h"

namespace plait::fuzz {

inline void check_base_mesh(const BaseMesh& mesh) {
  const auto faces = mesh.faces();
  const auto edges = mesh.edges();
  require(3 * mesh.face_count() + mesh.border_edge_count() == 2 * mesh.edge_count());
  require(mesh.face_edges().size() == mesh.face_count());
  for (const Vector3<double>& p : mesh.positions())
    require(std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z));
  for (std::size_t face = 0; face < faces.size(); ++face)
    for (std::size_t side = 0; side < 3; ++side) {
      require(faces[face][side] < mesh.vertex_count());
      const EdgeId edge = mesh.face_edges()[face][side];
      require(edge < mesh.edge_count());
      const VertexId start = faces[face][(side + 1) % 3], end = faces[face][(side + 2) % 3];
      require((edges[edge].start == start && edges[edge].end == end) ||
              (edges[edge].start == end && edges[edge].end == start));
    }
  for (const EdgeId edge : mesh.border_edges())
    require(edge < mesh.edge_count() && edges[edge].is_border());
}

/// `read` is one of those in mesh/files/readers.h.
template <class Reader>
void check_reader(Reader read, const std::uint8_t* data, std::size_t size) {
  const std::filesystem::path path = path_of(data, size);
  std::vector<std::string> warnings;
  accepts({ErrorCode::kInvalidArgument}, [&] {
    Input input(path);
    Reading reading{
        .attributes = size % 2 == 0, .face_attributes = size % 3 == 0, .warnings = &warnings};
    AttributedMesh mesh = read(input, reading);
    for (const MeshAttribute& attribute : mesh.face_attributes)
      require(attribute.records.size() == mesh.mesh.faces.size() * attribute.schema.record_bytes());
    check_base_mesh(BaseMesh::build(std::move(mesh.mesh), path.native(), &warnings));
  });
  for (const std::string& warning : warnings) require(is_one_short_line(warning));
}

}  // namespace plait::fuzz
