// Surfaces in a coordinate plane. All their tangents have exact zeros, and the signs of zeros are
// part of the bits that must agree.
#include <catch2/catch.hpp>

#include "acceptance/variants.h"
#include "support/test_meshes.h"

using namespace plait;
using namespace plait::test;

TEST_CASE("Digest_SurfaceInACoordinatePlane_IsThatOfEitherExecutor") {
  for (const int axis : {0, 1, 2}) {
    INFO("axis " << axis);
    IndexedMesh mesh = random_sheet(5, 200);
    // Rotates the sheet, which is in the plane of its first two coordinates, so that this plane is
    // normal to the axis.
    for (Vector3<double>& position : mesh.positions) {
      Vector3<double> flat{};
      flat[(axis + 1) % 3] = position.x;
      flat[(axis + 2) % 3] = position.y;
      position = flat;
    }
    Refiner refiner(BaseMesh::build(mesh), 4);
    Variant variant;
    const std::string expected = refiner.digest_of(variant);
    variant.executor = ExecutorKind::kTransparent;
    CHECK(refiner.digest_of(variant) == expected);
  }
}
