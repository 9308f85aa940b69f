// The whole index at compile time: a tetrahedron and a triangle as constexpr arrays.
#include <array>
#include <catch2/catch.hpp>

#include "plait/extend/edge_index.h"

using namespace plait;

namespace {

// Face 0 = (0,1,2), 1 = (0,2,3), 2 = (0,3,1), 3 = (1,3,2); sides: [face][side] -> edge.
constexpr std::array<std::array<VertexId, 3>, 4> kFaces{
    {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {1, 3, 2}}};
constexpr std::array<std::array<EdgeId, 3>, 4> kFaceEdges{
    {{1, 2, 0}, {3, 4, 2}, {5, 0, 4}, {3, 1, 5}}};
constexpr std::array<Edge, 6> kEdges{{{0, 1, {0, 2}, {2, 1}},
                                      {1, 2, {0, 0}, {3, 1}},
                                      {0, 2, {1, 2}, {0, 1}},
                                      {2, 3, {1, 0}, {3, 0}},
                                      {0, 3, {2, 2}, {1, 1}},
                                      {1, 3, {3, 2}, {2, 0}}}};
constexpr std::array<FaceSide, 4> kCorners{{{0, 0}, {3, 0}, {1, 1}, {2, 1}}};
constexpr Topology kTetrahedron{kFaces, kFaceEdges, kEdges, kCorners, {}};

constexpr std::array<std::array<VertexId, 3>, 1> kOneFace{{{0, 1, 2}}};
constexpr std::array<std::array<EdgeId, 3>, 1> kOneFaceEdges{{{1, 2, 0}}};
constexpr std::array<Edge, 3> kThreeEdges{
    {{0, 1, {0, 2}, {}}, {1, 2, {0, 0}, {}}, {2, 0, {0, 1}, {}}}};
constexpr Topology kTriangle{kOneFace, kOneFaceEdges, kThreeEdges, {}, {}};

constexpr bool round_trips(const Topology& mesh, int level) {
  const std::int64_t size = std::int64_t{1} << level;
  for (FaceId face = 0; face < mesh.faces.size(); ++face) {
    for (std::int64_t i = 0; i <= size; ++i) {
      for (std::int64_t j = 0; i + j <= size; ++j) {
        if (is_corner(level, i, j)) continue;
        const EdgeIndex at = edge_index(mesh, {face, level, i, j});
        if (!(edge_index(mesh, face_index(mesh, at)) == at)) return false;
      }
    }
  }
  return true;
}

static_assert(round_trips(kTetrahedron, 1) && round_trips(kTetrahedron, 4));
static_assert(round_trips(kTriangle, 1) && round_trips(kTriangle, 4));

// The paper's three cases at level 1: the middles of ab, bc and ca.
static_assert(to_side(1, 1, 0) == SideIndex{2, 1, 0, 0});
static_assert(to_side(1, 1, 1) == SideIndex{0, 1, 0, 0});
static_assert(to_side(1, 0, 1) == SideIndex{1, 1, 0, 0});
// By hand: weights (1, 4, 3) of 8 are born at level 3 beside ca, 3 of c and 1 of a.
static_assert(to_side(3, 4, 3) == SideIndex{1, 3, 1, 0});
static_assert(to_side(5, 16, 12) == SideIndex{1, 3, 1, 0});
static_assert(from_side(7, {1, 3, 1, 0}) == FaceIndex{7, 3, 4, 3});
// In the tetrahedron's face 0 side ca is edge 0-2, whose own face is 1: both coordinates mirrored.
static_assert(edge_index(kTetrahedron, {0, 3, 4, 3}) == EdgeIndex{2, 3, 2, 3});
static_assert(face_index(kTetrahedron, {2, 3, 2, 3}) == FaceIndex{0, 3, 4, 3});
static_assert(edge_index(kTriangle, {0, 3, 4, 3}) == EdgeIndex{2, 3, 1, 0});

static_assert(slot_side(1) == 1 && slot_side(kMaxLevel) == 524288);
static_assert(slot_records(3) == 16 && slot_records(3, SlotShape::kHalf) == 10);
static_assert(slot_position(3, SlotShape::kHalf, 1, 0) == 4 &&
              slot_position(3, SlotShape::kWhole, 1, 0) == 4);
static_assert(corner_point(1, 3, 2) == FaceIndex{1, 3, 0, 8} && corner_of(0, 8) == 2);
static_assert(at_level({0, 2, 1, 2}, 4) == FaceIndex{0, 4, 4, 8});
static_assert(at_level({0, 4, 4, 8}, 2) == FaceIndex{0, 2, 1, 2});
static_assert(side_beyond({0, 2, 1, 1}) == -1 && side_beyond({0, 2, 3, 2}) == 0);
static_assert(side_beyond({0, 2, -1, 3}) == 1 && side_beyond({0, 2, 3, -1}) == 2);
// Beyond bc of face 0 lies face 3 = (1,3,2), whose corner 1 is opposite.
static_assert(unfold(kTetrahedron, {0, 2, 3, 2}, 0) == FaceIndex{3, 2, 1, 1});
static_assert(kTetrahedron.is_own(0, 0) && !kTetrahedron.is_own(3, 1));
static_assert(kTetrahedron.across(FaceSide(0, 0)) == FaceSide(3, 1));
static_assert(kTetrahedron.next_corner(FaceSide(0, 0)) == FaceSide(1, 0));
static_assert(!kTriangle.across(FaceSide(0, 0)).exists());
static_assert(!kTriangle.next_corner(FaceSide(0, 0)).exists());
static_assert(!FaceSide().exists() && FaceSide(9, 2).face() == 9 && FaceSide(9, 2).side() == 2);

}  // namespace

TEST_CASE("EdgeIndex_CompileTimeTables_DescribeTheirFaces") {
  for (const Topology& mesh : {kTetrahedron, kTriangle}) {
    for (EdgeId e = 0; e < mesh.edges.size(); ++e) {
      const Edge& edge = mesh.edges[e];
      const auto side = static_cast<std::size_t>(edge.own.side());
      const auto& face = mesh.faces[edge.own.face()];
      REQUIRE(mesh.face_edges[edge.own.face()][side] == e);
      REQUIRE(face[(side + 1) % 3] == edge.start);
      REQUIRE(face[(side + 2) % 3] == edge.end);
    }
  }
}
