// A base mesh for measurements that are given none.
#pragma once

#include "plait/base_mesh.h"
#include "plait/kernels/subdivide.h"

namespace plait::bench {

/// An octahedron refined `times` times: 8 * 4^times faces.
inline BaseMesh refined_octahedron(int times) {
  IndexedMesh mesh;
  mesh.positions = {{1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  mesh.faces = {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4},
                {1, 0, 5}, {2, 1, 5}, {3, 2, 5}, {0, 3, 5}};
  return rebase(BaseMesh::build(mesh), times, Scheme::kLoop);
}

}  // namespace plait::bench
