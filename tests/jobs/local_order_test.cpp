// The local order of an import: another numbering of the same mesh, in which a face's vertices have
// near numbers.
#include "import/local_order.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdint>
#include <numeric>
#include <set>
#include <vector>

#include "support/shuffled_mesh.h"
#include "support/test_meshes.h"

using namespace plait;
using namespace plait::test;

namespace {

PlaceGrid grid_of(const IndexedMesh& mesh) {
  PlaceGrid grid;
  for (const Vector3<double>& position : mesh.positions) grid.include(position);
  return grid;
}

LocalMesh local_of(const IndexedMesh& mesh) {
  const PlaceGrid grid = grid_of(mesh);
  HugeArray<std::uint32_t> cells;
  for (const Vector3<double>& position : mesh.positions) cells.push_back(grid.cell(position));
  std::vector<FaceVertices> faces = mesh.faces;
  return local_mesh(faces, std::move(cells));
}

template <class Numbers>
bool is_permutation_of_all(const Numbers& numbers, std::size_t count) {
  const std::set<std::uint32_t> distinct(numbers.begin(), numbers.end());
  return numbers.size() == count && distinct.size() == count && *distinct.rbegin() == count - 1;
}

/// The mean of the difference between the smallest and the largest vertex of a face.
template <class Faces>
double mean_spread(const Faces& faces) {
  double sum = 0;
  for (const FaceVertices& face : faces) {
    const auto [least, most] = std::ranges::minmax(face);
    sum += most - least;
  }
  return sum / static_cast<double>(faces.size());
}

}  // namespace

TEST_CASE("LocalMesh_AnyMesh_IsTheMeshWithOtherNumbers") {
  unsigned seed = 0;
  for (const NamedMesh& each : all_meshes()) {
    INFO(each.name);
    const IndexedMesh mesh = shuffled(each.mesh, ++seed);
    const LocalMesh local = local_of(mesh);
    CHECK(is_permutation_of_all(local.file_vertices, mesh.positions.size()));
    CHECK(is_permutation_of_all(local.file_faces, mesh.faces.size()));
    CHECK(faces_of_file(local) == mesh.faces);
  }
}

TEST_CASE("LocalMesh_ShuffledSheet_HasNearNumbersAtAFace") {
  const IndexedMesh mesh = shuffled(sheet(200, 200), 3);
  const LocalMesh local = local_of(mesh);
  const auto vertices = static_cast<double>(mesh.positions.size());
  CHECK(mean_spread(mesh.faces) > vertices / 3);
  CHECK(mean_spread(local.faces) < vertices / 30);
  // Faces that follow each other are near each other, too.
  double steps = 0;
  for (std::size_t face = 1; face < local.faces.size(); ++face)
    steps += std::max(local.faces[face][0], local.faces[face - 1][0]) -
             std::min(local.faces[face][0], local.faces[face - 1][0]);
  CHECK(steps / static_cast<double>(local.faces.size()) < vertices / 30);
}

TEST_CASE("PlaceGrid_AnyPoints_AreInItsCells") {
  PlaceGrid point;
  point.include({3, 4, 5});
  CHECK(point.cell({3, 4, 5}) < PlaceGrid::kCells);
  PlaceGrid largest;
  largest.include({-1.7e308, 0, 1});
  largest.include({1.7e308, 0, 1});
  CHECK(largest.cell({-1.7e308, 0, 1}) == 0);
  CHECK(largest.cell({1.7e308, 0, 1}) < PlaceGrid::kCells);
  // Each cell of an axis is another one; x, y and z take every third bit.
  PlaceGrid cube;
  cube.include({0, 0, 0});
  cube.include({64, 64, 64});
  std::set<std::uint32_t> cells;
  for (int at = 0; at < 64; ++at) {
    const double middle = at + 0.5;
    cells.insert(cube.cell({middle, 0, 0}));
    CHECK(cube.cell({0, middle, 0}) == 2 * cube.cell({middle, 0, 0}));
    CHECK(cube.cell({0, 0, middle}) == 4 * cube.cell({middle, 0, 0}));
    CHECK((cube.cell({middle, 0, 0}) & ~std::uint32_t{0x9249}) == 0);
  }
  CHECK(cells.size() == 64);
  CHECK(cube.cell({64, 64, 64}) == PlaceGrid::kCells - 1);
}
