#include "acceptance/meshes.h"

#include <array>
#include <utility>

#include "generate/generate.h"
#include "plait/mesh_io.h"
#include "support/real_meshes.h"
#include "support/test_meshes.h"

namespace plait::test {
namespace {

/// Removes `holes` faces that share no vertex. This adds as many border loops.
IndexedMesh perforated(IndexedMesh mesh, std::size_t holes) {
  std::vector<bool> beside_a_hole(mesh.positions.size(), false);
  std::vector<std::array<VertexId, 3>> kept;
  const std::size_t distance = mesh.faces.size() / (2 * holes);
  std::size_t next_hole = 0;
  for (std::size_t face = 0; face < mesh.faces.size(); ++face) {
    const auto& [a, b, c] = mesh.faces[face];
    if (holes > 0 && face >= next_hole && !beside_a_hole[a] && !beside_a_hole[b] &&
        !beside_a_hole[c]) {
      beside_a_hole[a] = beside_a_hole[b] = beside_a_hole[c] = true;
      next_hole = face + distance;
      --holes;
    } else {
      kept.push_back(mesh.faces[face]);
    }
  }
  mesh.faces = std::move(kept);
  return mesh;
}

}  // namespace

std::vector<AcceptanceMesh> generated_meshes(std::uint64_t vertices) {
  const auto make = [](GeneratorKind kind, std::uint64_t count) {
    return [=] { return generate(kind, count, 1); };
  };
  return {{"molecule", make(GeneratorKind::kMolecule, vertices)},
          {"open sheet", make(GeneratorKind::kOpenSheet, vertices)},
          {"torus", make(GeneratorKind::kTorus, vertices)},
          {"icosphere", make(GeneratorKind::kIcosphere, vertices)},
          {"molecule with holes",
           [=] { return perforated(generate(GeneratorKind::kMolecule, vertices, 2), 9); }},
          {"components", [=] {
             return side_by_side({generate(GeneratorKind::kMolecule, vertices / 2, 3),
                                  generate(GeneratorKind::kOpenSheet, vertices / 4, 3),
                                  generate(GeneratorKind::kTorus, vertices / 4, 3), tetrahedron(),
                                  single_triangle(), closed_fan(40), bipyramid(26), annulus(9)});
           }}};
}

std::vector<AcceptanceMesh> real_meshes() {
  std::vector<AcceptanceMesh> meshes;
  for (const std::string name :
       {"deo_like", "bunny", "bunny_open", "koala", "lysozyme_waters", "spot"})
    if (has_real_mesh(name))
      meshes.push_back({name, [name] { return read_indexed_mesh(real_mesh_path(name)); }});
  return meshes;
}

}  // namespace plait::test
