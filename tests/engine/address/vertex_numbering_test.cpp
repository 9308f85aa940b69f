// Vertex numbers: a bijection onto 0 .. V-1, and triangles over them that make the same surface.
#include "plait/extend/vertex_numbering.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <map>
#include <utility>

#include "support/test_meshes.h"

using namespace plait;
using namespace plait::test;

namespace {

constexpr int kLevels = 4;

}  // namespace

TEST_CASE("VertexNumbering_EveryMesh_IsABijectionLevelByLevel") {
  for (const NamedMesh& named : all_meshes()) {
    INFO(named.name);
    const BaseMesh base = BaseMesh::build(named.mesh);
    const VertexNumbering numbering(base.topology(), kLevels);
    REQUIRE(numbering.vertex_count() == counts_at_level(base, kLevels).vertices);
    REQUIRE(numbering.first_of(0) == 0);
    for (int level = 1; level <= kLevels; ++level)
      REQUIRE(numbering.first_of(level) == counts_at_level(base, level - 1).vertices);

    // One point of every vertex: two points of one vertex would leave another without.
    std::vector<FaceIndex> point_of(numbering.vertex_count(), {kNoId, 0, 0, 0});
    std::uint64_t found = 0;
    bool right_level = true, same_everywhere = true;
    constexpr std::int64_t kSize = 1 << kLevels;
    for (FaceId face = 0; face < base.face_count(); ++face)
      for (std::int64_t j = 0; j <= kSize; ++j)
        for (std::int64_t i = 0; i + j <= kSize; ++i) {
          const FaceIndex point{face, kLevels, i, j};
          const std::uint64_t number = numbering.number(point);
          REQUIRE(number < numbering.vertex_count());
          int born = kLevels;  // the coarsest level that has this point
          while (born > 0 && ((i | j) >> (kLevels - born) & 1) == 0) --born;
          if (is_corner(kLevels, i, j)) born = 0;
          right_level &= number >= numbering.first_of(born) &&
                         (born == kLevels || number < numbering.first_of(born + 1));
          same_everywhere &= numbering.number(at_level(point, std::max(born, 1))) == number;
          if (point_of[number].face == kNoId) {
            point_of[number] = point;
            ++found;
          }
        }
    CHECK(right_level);
    CHECK(same_everywhere);
    CHECK(found == numbering.vertex_count());
  }
}

TEST_CASE("VertexNumbering_LevelZero_IsThatOfTheBaseMesh") {
  const BaseMesh base = BaseMesh::build(random_sheet(3, 50));
  const VertexNumbering numbering(base.topology(), 0);
  CHECK(numbering.vertex_count() == base.vertex_count());
  for (FaceId face = 0; face < base.face_count(); ++face)
    for (int corner = 0; corner < 3; ++corner)
      CHECK(numbering.number(corner_point(face, 0, corner)) ==
            base.faces()[face][static_cast<std::size_t>(corner)]);
}

TEST_CASE("ForEachTriangle_EveryMesh_CoversItOnce") {
  for (const NamedMesh& named : all_meshes())
    for (const int level : {0, 1, 3}) {
      INFO(named.name << ", level " << level);
      const BaseMesh base = BaseMesh::build(named.mesh);
      const VertexNumbering numbering(base.topology(), level);
      using Directed = std::pair<std::uint64_t, std::uint64_t>;
      std::map<Directed, int> sides;
      std::uint64_t triangles = 0;
      for (FaceId face = 0; face < base.face_count(); ++face)
        for_each_triangle(level, [&](const std::array<FacePoint, 3>& corners) {
          ++triangles;
          std::array<std::uint64_t, 3> numbers;
          for (std::size_t k = 0; k < 3; ++k)
            numbers[k] = numbering.number({face, level, corners[k].i, corners[k].j});
          for (std::size_t k = 0; k < 3; ++k) ++sides[{numbers[k], numbers[(k + 1) % 3]}];
        });
      CHECK(triangles == base.face_count() << (2 * level));
      // An oriented manifold has each side of a triangle once, and the opposite one unless it is
      // on the border.
      std::uint64_t border = 0;
      bool once = true;
      for (const auto& [side, count] : sides) {
        once &= count == 1;
        if (!sides.contains({side.second, side.first})) ++border;
      }
      CHECK(once);
      CHECK(border == base.border_edge_count() << level);
      const std::uint64_t edges = (sides.size() + border) / 2;
      CHECK(edges == counts_at_level(base, level).edges);
      CHECK(numbering.vertex_count() + triangles - edges ==
            base.vertex_count() + base.face_count() - base.edge_count());
    }
}
