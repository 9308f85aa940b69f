#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <limits>
#include <map>
#include <numeric>
#include <set>
#include <vector>

#include "layout/hilbert.h"
#include "plait/error.h"
#include "plait/layout.h"
#include "support/test_meshes.h"

namespace plait::test {
using plait::layout::hilbert_key;
using plait::layout::kHilbertBits;

namespace {

using Cell = std::array<std::uint32_t, 3>;

/// The cells of a cube with `side` cells per axis and its lowest cell at `corner`, by key.
std::map<std::uint64_t, Cell> cube_by_key(std::uint32_t corner, std::uint32_t side) {
  std::map<std::uint64_t, Cell> cells;
  for (std::uint32_t x = corner; x < corner + side; ++x)
    for (std::uint32_t y = corner; y < corner + side; ++y)
      for (std::uint32_t z = corner; z < corner + side; ++z)
        cells[hilbert_key({x, y, z})] = {x, y, z};
  return cells;
}

int distance(const Cell& a, const Cell& b) {
  int sum = 0;
  for (std::size_t axis = 0; axis < 3; ++axis)
    sum += std::abs(static_cast<int>(a[axis]) - static_cast<int>(b[axis]));
  return sum;
}

}  // namespace

TEST_CASE("HilbertKey_AlignedCubes_AreFilledByNeighbourAfterNeighbour") {
  constexpr std::uint32_t kSide = 16;
  for (const std::uint32_t corner : {0u, 16u, 1u << 20, (1u << kHilbertBits) - kSide}) {
    const std::map<std::uint64_t, Cell> cells = cube_by_key(corner, kSide);
    REQUIRE(cells.size() == kSide * kSide * kSide);
    CHECK(cells.rbegin()->first - cells.begin()->first == cells.size() - 1);
    int breaks = 0;
    for (auto cell = cells.begin(), next = std::next(cell); next != cells.end(); ++cell, ++next)
      breaks += distance(cell->second, next->second) == 1 ? 0 : 1;
    CHECK(breaks == 0);
  }
}

TEST_CASE("HilbertKey_OriginAndRange_AreZeroAndBelow63Bits") {
  CHECK(hilbert_key({0, 0, 0}) == 0);
  constexpr std::uint32_t kLast = (1u << kHilbertBits) - 1;
  for (const Cell cell :
       {Cell{kLast, 0, 0}, Cell{0, kLast, 0}, Cell{0, 0, kLast}, Cell{kLast, kLast, kLast}})
    CHECK(hilbert_key(cell) < std::uint64_t{1} << (3 * kHilbertBits));
}

using Catch::Contains;

namespace {

constexpr std::array kOrders{LayoutKind::kGiven, LayoutKind::kSpatial, LayoutKind::kHilbert,
                             LayoutKind::kRcm};

bool is_permutation_of_faces(std::vector<FaceId> order, std::size_t face_count) {
  std::vector<FaceId> expected(face_count);
  std::iota(expected.begin(), expected.end(), FaceId{0});
  std::sort(order.begin(), order.end());
  return order == expected;
}

/// A grid of separate triangles, so each face is a component.
IndexedMesh dust(std::uint32_t count) {
  IndexedMesh mesh;
  for (std::uint32_t i = 0; i < count; ++i) {
    const double x = i % 1000, y = i / 1000;
    mesh.positions.push_back({x, y, 0});
    mesh.positions.push_back({x + 0.5, y, 0});
    mesh.positions.push_back({x, y + 0.5, 0});
    mesh.faces.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  return mesh;
}

}  // namespace

TEST_CASE("FaceOrder_EveryMeshAndLayout_IsAPermutationAndRepeats") {
  for (const test::NamedMesh& named : test::all_meshes()) {
    const BaseMesh mesh = BaseMesh::build(named.mesh);
    for (const LayoutKind kind : kOrders) {
      INFO(named.name << " " << to_string(kind));
      const std::vector<FaceId> order = face_order(mesh, kind);
      CHECK(is_permutation_of_faces(order, mesh.face_count()));
      CHECK(face_order(mesh, kind) == order);
    }
  }
}

TEST_CASE("FaceOrder_MeshWithoutFaces_IsEmpty") {
  for (const LayoutKind kind : kOrders) CHECK(face_order(BaseMesh(), kind).empty());
}

TEST_CASE("FaceOrder_Given_IsTheIdentity") {
  const BaseMesh mesh = BaseMesh::build(test::random_sphere(3, 50));
  const std::vector<FaceId> order = face_order(mesh, LayoutKind::kGiven);
  CHECK(std::is_sorted(order.begin(), order.end()));
}

TEST_CASE("FaceOrder_Spatial_SortsCentroidsAlongTheLongestAxisAndKeepsTies") {
  for (int longest = 0; longest < 3; ++longest) {
    IndexedMesh input = test::torus_grid(9, 7);
    for (Vector3<double>& position : input.positions) position[longest] *= 100;
    const BaseMesh mesh = BaseMesh::build(input);
    const std::vector<FaceId> order = face_order(mesh, LayoutKind::kSpatial);
    const auto centroid = [&](FaceId face) {
      double sum = 0;
      for (const VertexId vertex : mesh.faces()[face]) sum += mesh.positions()[vertex][longest] / 3;
      return sum;
    };
    for (std::size_t i = 1; i < order.size(); ++i) {
      const double before = centroid(order[i - 1]), here = centroid(order[i]);
      CHECK((before < here || (before == here && order[i - 1] < order[i])));
    }
  }
}

TEST_CASE("FaceOrder_Hilbert_FollowsTheCurveThroughTheEightOctants") {
  const BaseMesh mesh = BaseMesh::build(test::octahedron());
  const std::vector<FaceId> order = face_order(mesh, LayoutKind::kHilbert);
  const auto octant = [&](FaceId face) {
    Vector3<double> sum{0, 0, 0};
    for (const VertexId vertex : mesh.faces()[face]) sum = sum + mesh.positions()[vertex];
    return (sum.x > 0 ? 1 : 0) + (sum.y > 0 ? 2 : 0) + (sum.z > 0 ? 4 : 0);
  };
  for (std::size_t i = 1; i < order.size(); ++i)
    CHECK(__builtin_popcount(static_cast<unsigned>(octant(order[i - 1]) ^ octant(order[i]))) == 1);
}

TEST_CASE("FaceOrder_Rcm_OfAStripOfTriangles_WalksFromEndToEnd") {
  // Each face of the open fan touches the next one. The input has the faces in another order.
  IndexedMesh input = test::open_fan(40);
  std::vector<std::array<VertexId, 3>> shuffled;
  for (std::size_t i = 0; i < 40; ++i) shuffled.push_back(input.faces[(i * 7 + 20) % 40]);
  const BaseMesh mesh = BaseMesh::build({input.positions, shuffled});
  const std::vector<FaceId> order = face_order(mesh, LayoutKind::kRcm);
  for (std::size_t i = 1; i < order.size(); ++i) {
    const int from = static_cast<int>((order[i - 1] * 7 + 20) % 40);
    const int to = static_cast<int>((order[i] * 7 + 20) % 40);
    CHECK(std::abs(to - from) == 1);
  }
}

TEST_CASE("FaceOrder_Rcm_IsABreadthFirstSearchByDegreeReversed") {
  for (const IndexedMesh& input : {test::random_sheet(4, 300), test::random_sphere(5, 300)}) {
    const BaseMesh mesh = BaseMesh::build(input);
    const auto neighbours_of = [&](FaceId face) {
      std::vector<FaceId> neighbours;
      for (int side = 0; side < 3; ++side)
        if (const FaceSide beyond = mesh.topology().across(FaceSide(face, side)); beyond.exists())
          neighbours.push_back(beyond.face());
      return neighbours;
    };
    std::vector<FaceId> order = face_order(mesh, LayoutKind::kRcm);
    std::ranges::reverse(order);
    std::vector<std::size_t> place(order.size());
    for (std::size_t i = 0; i < order.size(); ++i) place[order[i]] = i;
    // The search found a face from its first neighbour in the order.
    std::size_t last_finder = 0, last_degree = 0, faces_of_other_degrees = 0;
    for (std::size_t i = 1; i < order.size(); ++i) {
      INFO("face " << order[i] << " at place " << i);
      const std::vector<FaceId> neighbours = neighbours_of(order[i]);
      std::size_t finder = i;
      for (const FaceId next : neighbours) finder = std::min(finder, place[next]);
      REQUIRE(finder < i);
      CHECK(finder >= last_finder);
      if (finder == last_finder && i > 1) {
        CHECK(neighbours.size() >= last_degree);
        if (neighbours.size() != last_degree) ++faces_of_other_degrees;
      }
      last_finder = finder;
      last_degree = neighbours.size();
    }
    // Otherwise this case would not test the order by degree.
    if (mesh.border_edge_count() > 0) CHECK(faces_of_other_degrees > 5);
  }
}

TEST_CASE("FaceOrder_AHundredThousandComponents_TakesNoQuadraticTime") {
  constexpr std::uint32_t kComponents = 100'000;
  const BaseMesh mesh = BaseMesh::build(dust(kComponents));
  for (const LayoutKind kind : kOrders)
    CHECK(is_permutation_of_faces(face_order(mesh, kind), kComponents));
}

TEST_CASE("FaceOrder_PositionsOfNoExtentOrTheLargestThereIs_AreStillAPermutation") {
  constexpr double kHuge = std::numeric_limits<double>::max();
  IndexedMesh point = test::icosahedron(), huge = test::icosahedron();
  for (Vector3<double>& position : point.positions) position = {2, 2, 2};
  for (Vector3<double>& position : huge.positions)
    for (int axis = 0; axis < 3; ++axis) position[axis] = position[axis] > 0 ? kHuge : -kHuge;
  for (const IndexedMesh& input : {point, huge}) {
    const BaseMesh mesh = BaseMesh::build(input);
    for (const LayoutKind kind : kOrders)
      CHECK(is_permutation_of_faces(face_order(mesh, kind), mesh.face_count()));
  }
}

TEST_CASE("FaceOrder_Automatic_IsRefused") {
  const BaseMesh mesh = BaseMesh::build(test::tetrahedron());
  CHECK_THROWS_WITH(face_order(mesh, LayoutKind::kAutomatic), Contains("auto"));
}

TEST_CASE("LayoutNames_EveryKind_ReadsBackAndOthersAreRefused") {
  for (const LayoutKind kind : {LayoutKind::kGiven, LayoutKind::kSpatial, LayoutKind::kHilbert,
                                LayoutKind::kRcm, LayoutKind::kAutomatic})
    CHECK(layout_from_name(to_string(kind)) == kind);
  CHECK_THROWS_WITH(layout_from_name("morton"), Contains("hilbert") && Contains("morton"));
  CHECK_THROWS_AS(layout_from_name(""), Error);
}

}  // namespace plait::test
