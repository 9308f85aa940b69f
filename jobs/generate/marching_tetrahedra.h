// generate/marching_tetrahedra.h: the level set of a field on a grid, as a closed surface.
#pragma once

#include <cstddef>
#include <functional>
#include <span>

#include "generate/progress.h"
#include "plait/base_mesh.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace generation {

/// A box of grid points origin + spacing * (x, y, z).
struct Grid {
  Vector3<double> origin;
  double spacing;
  std::size_t width, height, depth;  ///< points along x, y, z
};

/// Writes the field's values at one z: [y][x] float32.
using FieldLayer = std::function<void(std::size_t z, std::span<float> values)>;

/// The surface between grid points with values above `level` and all others. It is oriented away
/// from the values above. Each cube is divided into six tetrahedra around its main diagonal, which
/// match those of the neighbouring cubes face to face. So the result is an oriented 2-manifold, and
/// it is closed if the outermost grid points are not above the level. Vertices are in the order of
/// z. Memory: the surface and two layers.
/// Source: A. Doi, A. Koide, "An efficient method of triangulating equi-valued surfaces by using
/// tetrahedral cells" (1991).
IndexedMesh march_tetrahedra(const Grid& grid, float level, const FieldLayer& field,
                             const Progress& progress);

}  // namespace generation
PLAIT_END_NAMESPACE
