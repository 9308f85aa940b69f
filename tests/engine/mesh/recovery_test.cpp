// Recovery of levels: the base mesh and the patches of meshes that an oracle refined, whatever the
// order of vertices, faces and corners; and where meshes without levels fail.
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>
#include <random>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "mesh/recovery/recover_levels.h"
#include "support/naive_subdivision.h"
#include "support/shuffled_mesh.h"
#include "support/test_meshes.h"

using namespace plait;
using namespace plait::test;

namespace {

/// A mesh that the oracle has refined by midpoints, and then shuffled.
struct Refined {
  Refined(const IndexedMesh& base, int levels, unsigned seed)
      : Refined(refined(base, levels), seed) {}
  Refined(const IndexedMesh& fine, unsigned seed) : mesh(shuffled(fine, seed, &former)) {
    MatchedSides sides = match_sides(mesh.faces, mesh.positions.size(), "test");
    REQUIRE(sides.oriented);
    twins = std::move(sides.twins);
  }

  static IndexedMesh refined(const IndexedMesh& base, int levels) {
    const naive::Mesh fine = naive::subdivide(to_naive(base), naive::Scheme::kMidpoint, levels);
    IndexedMesh mesh;
    for (const naive::Point& p : fine.points) mesh.positions.push_back({p.x, p.y, p.z});
    mesh.faces.assign(fine.triangles.begin(), fine.triangles.end());
    return mesh;
  }
  FinestMesh view() const { return {mesh.faces, twins, mesh.positions.size()}; }

  std::vector<VertexId> former;  ///< [vertex] its number before the shuffle
  IndexedMesh mesh;
  std::vector<SideCodes> twins;
};

using Faces = std::multiset<std::array<VertexId, 3>>;

std::array<VertexId, 3> from_smallest(std::array<VertexId, 3> face) {
  std::ranges::rotate(face, std::ranges::min_element(face));
  return face;
}

/// The faces of the base mesh by their former numbers.
Faces base_faces(const Refined& fine, const LevelMesh& base) {
  const FinestMesh finest = fine.view();
  const LevelView view(finest, base);
  Faces faces;
  for (FaceId face = 0; face < view.face_count(); ++face)
    faces.insert(
        from_smallest({fine.former[view.vertex({face, 0})], fine.former[view.vertex({face, 1})],
                       fine.former[view.vertex({face, 2})]}));
  return faces;
}

/// Points of patches that are not where the corners and midpoints say.
std::uint64_t wrong_points(const Refined& fine, const LevelMesh& base, int levels) {
  const FinestMesh finest = fine.view();
  const LevelView view(finest, base);
  const std::int64_t size = std::int64_t{1} << levels;
  std::vector<FaceSide> first_corners;
  for (FaceId face = 0; face < view.face_count(); ++face)
    first_corners.push_back(view.finest_corner({face, 0}));
  std::vector<VertexId> patches(first_corners.size() *
                                static_cast<std::size_t>((size + 1) * (size + 2) / 2));
  walk_patches(finest, first_corners, levels, patches.data());
  std::uint64_t wrong = 0;
  auto at = patches.begin();
  for (FaceId face = 0; face < view.face_count(); ++face) {
    std::array<Vector3<double>, 3> corners;
    for (int corner = 0; corner < 3; ++corner)
      corners[static_cast<std::size_t>(corner)] = fine.mesh.positions[view.vertex({face, corner})];
    for (std::int64_t j = 0; j <= size; ++j)
      for (std::int64_t i = 0; i + j <= size; ++i, ++at) {
        const auto weight = [&](std::int64_t k) {
          return static_cast<double>(k) / static_cast<double>(size);
        };
        const Vector3<double> expected =
            weight(size - i - j) * corners[0] + weight(i) * corners[1] + weight(j) * corners[2];
        const Vector3<double> away = fine.mesh.positions[*at] - expected;
        wrong += std::abs(away.x) + std::abs(away.y) + std::abs(away.z) > 1e-9;
      }
  }
  return wrong;
}

Faces faces_of(const IndexedMesh& mesh) {
  Faces faces;
  for (const auto& face : mesh.faces) faces.insert(from_smallest(face));
  return faces;
}

}  // namespace

TEST_CASE("RecoverLevels_ShuffledMidpoints_AreTheBaseMeshAndItsPatches") {
  const int levels = GENERATE(1, 2, 3);
  unsigned seed = 0;
  for (const NamedMesh& each : all_meshes()) {
    if (each.mesh.faces.size() << 2 * levels > 100000) continue;
    INFO(each.name << ", " << levels << " levels");
    const Refined fine(each.mesh, levels, ++seed);
    const RecoveredLevels found = recover_levels(fine.view(), levels);
    CHECK(!found.failure);
    REQUIRE(found.meshes.size() == static_cast<std::size_t>(levels));
    if (!found.had_choice) CHECK(base_faces(fine, found.meshes.back()) == faces_of(each.mesh));
    CHECK(found.meshes.back().twins.size() == each.mesh.faces.size());
    if (!found.had_choice) CHECK(wrong_points(fine, found.meshes.back(), levels) == 0);
    for (int finer = 1; finer < levels && !found.had_choice; ++finer)
      CHECK(wrong_points(fine, found.meshes[static_cast<std::size_t>(finer) - 1], finer) == 0);
  }
}

TEST_CASE("RecoverLevels_VertexOfManyFaces_IsKept") {
  for (const IndexedMesh& base : {bipyramid(50), open_fan(40), closed_fan(40)}) {
    const Refined fine(base, 2, 7);
    const RecoveredLevels found = recover_levels(fine.view(), 2);
    REQUIRE(found.meshes.size() == 2);
    CHECK(base_faces(fine, found.meshes.back()) == faces_of(base));
    CHECK(wrong_points(fine, found.meshes.back(), 2) == 0);
  }
}

TEST_CASE("RecoverLevels_ComponentsOfDifferentParity_AreOneMesh") {
  const IndexedMesh base = side_by_side({icosahedron(), sheet(3, 2), seven_vertex_torus()});
  const Refined fine(base, 2, 4);
  const RecoveredLevels found = recover_levels(fine.view(), 20);
  REQUIRE(found.meshes.size() == 2);
  CHECK(found.meshes.back().twins.size() == base.faces.size());
  CHECK(found.failure);
  // One component has two levels more than the other.
  const IndexedMesh uneven =
      side_by_side({Refined::refined(icosahedron(), 3), Refined::refined(octahedron(), 1)});
  const Refined both(uneven, 9);
  CHECK(recover_levels(both.view(), 20).meshes.size() == 1);
}

TEST_CASE("RecoverLevels_TorusWithoutIrregularVertices_KeepsTheSmallestVertex") {
  for (unsigned seed = 1; seed < 6; ++seed) {
    const Refined fine(Refined::refined(torus_grid(3, 5), 3), seed);
    const RecoveredLevels found = recover_levels(fine.view(), 20);
    CHECK(found.had_choice);
    REQUIRE(found.meshes.size() == 3);
    CHECK(found.failure);
    const FinestMesh finest = fine.view();
    const LevelView base(finest, found.meshes.back());
    std::set<VertexId> kept;
    for (FaceId face = 0; face < base.face_count(); ++face)
      for (int corner = 0; corner < 3; ++corner) kept.insert(base.vertex({face, corner}));
    CHECK(kept.size() == 15);
    CHECK(*kept.begin() == 0);
  }
  // Another choice of faces and corners gives the same vertices.
  IndexedMesh mesh = Refined::refined(torus_grid(4, 6), 1);
  std::set<std::set<VertexId>> answers;
  for (int turn = 0; turn < 3; ++turn) {
    for (auto& face : mesh.faces) std::ranges::rotate(face, face.begin() + 1);
    std::ranges::rotate(mesh.faces, mesh.faces.begin() + 17);
    MatchedSides sides = match_sides(mesh.faces, mesh.positions.size(), "test");
    const FinestMesh finest{mesh.faces, sides.twins, mesh.positions.size()};
    const RecoveredLevels found = recover_levels(finest, 1);
    REQUIRE(found.meshes.size() == 1);
    const LevelView base(finest, found.meshes.back());
    std::set<VertexId> kept;
    for (FaceId face = 0; face < base.face_count(); ++face)
      for (int corner = 0; corner < 3; ++corner) kept.insert(base.vertex({face, corner}));
    answers.insert(kept);
  }
  CHECK(answers.size() == 1);
}

TEST_CASE("RecoverLevels_RegularRing_FindsTheAnswerThatItsBordersAllow") {
  // A ring of triangles: all vertices inside have six faces, all on the borders three.
  const Refined fine(annulus(6), 2, 3);
  const RecoveredLevels found = recover_levels(fine.view(), 2);
  REQUIRE(found.meshes.size() == 2);
  CHECK(found.meshes.back().twins.size() == annulus(6).faces.size());
}

TEST_CASE("RecoverLevels_OneTurnedEdge_NamesAVertexNearIt") {
  IndexedMesh mesh = Refined::refined(icosahedron(), 3);
  // Turns the edge between faces 100 and its neighbour.
  MatchedSides sides = match_sides(mesh.faces, mesh.positions.size(), "test");
  const FaceSide other = [&] {
    FaceSide side;
    side.code = sides.twins[100][0];
    return side;
  }();
  auto &a = mesh.faces[100], &b = mesh.faces[other.face()];
  const VertexId apex = a[0], start = a[1], end = a[2],
                 far = b[static_cast<std::size_t>(other.side())];
  a = {apex, start, far};
  b = {far, end, apex};
  const Refined fine(mesh, 2);
  const RecoveredLevels found = recover_levels(fine.view(), 20);
  CHECK(found.meshes.empty());
  REQUIRE(found.failure);
  const VertexId named = fine.former[found.failure->vertex];
  CHECK((named == apex || named == start || named == end || named == far));
  CHECK((found.failure->faces == 5 || found.failure->faces == 7));
  CHECK(found.failure->reason.find("six faces") != std::string::npos);
  CHECK(!found.failure->on_border);
}

TEST_CASE("RecoverLevels_MeshesWithoutLevels_AreNamed") {
  for (const IndexedMesh& mesh :
       {tetrahedron(), icosahedron(), octahedron(), single_triangle(), seven_vertex_torus(),
        torus_grid(3, 3), two_faces_back_to_back()}) {
    const Refined fine(mesh, 0, 1);
    const RecoveredLevels found = recover_levels(fine.view(), 20);
    CHECK(found.meshes.empty());
    REQUIRE(found.failure);
    CHECK(found.failure->vertex < mesh.positions.size());
    CHECK(found.failure->faces > 0);
    CHECK(!found.failure->reason.empty());
  }
  // The coarser mesh of a torus of four by four vertices would have two edges between two vertices.
  const Refined small(torus_grid(4, 4), 0, 1);
  const RecoveredLevels found = recover_levels(small.view(), 20);
  CHECK(found.meshes.empty());
  CHECK(found.failure->reason.find("two edges") != std::string::npos);
}

namespace {

/// What recover_levels() found, as the file names it: for each level the corners of its faces, each
/// with its finest face, in the order of the file; and the failure.
struct Answer {
  std::vector<std::vector<std::array<std::uint32_t, 6>>> levels;
  bool had_choice = false;
  std::optional<std::tuple<VertexId, std::uint32_t, bool, std::string>> failure;
  bool operator==(const Answer&) const = default;
};

Answer answer_of(const FinestMesh& finest) {
  const RecoveredLevels found = recover_levels(finest, 20);
  Answer answer{{}, found.had_choice, std::nullopt};
  if (const auto& failure = found.failure)
    answer.failure = {failure->vertex, failure->faces, failure->on_border, failure->reason};
  for (const LevelMesh& level : found.meshes) {
    const LevelView view(finest, level);
    std::vector<FaceId> faces(view.face_count());
    std::iota(faces.begin(), faces.end(), FaceId{0});
    view.sort_as_in_file(faces);
    for (auto& of_level = answer.levels.emplace_back(); const FaceId face : faces) {
      auto& corners = of_level.emplace_back();
      for (int at = 0; at < 3; ++at) {
        const auto corner = static_cast<std::size_t>(at);
        const FaceId fine = view.finest_corner({face, at}).face();
        corners[corner] = view.file_vertex({face, at});
        corners[3 + corner] = finest.file_faces.empty() ? fine : finest.file_faces[fine];
      }
    }
  }
  return answer;
}

/// The answer for the same file if its vertices and faces get random numbers.
Answer answer_with_other_numbers(const IndexedMesh& file, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<VertexId> vertices(file.positions.size()), number(vertices.size());
  std::vector<FaceId> faces(file.faces.size());
  std::iota(vertices.begin(), vertices.end(), VertexId{0});
  std::iota(faces.begin(), faces.end(), FaceId{0});
  std::ranges::shuffle(vertices, random);
  std::ranges::shuffle(faces, random);
  for (VertexId vertex = 0; vertex < vertices.size(); ++vertex) number[vertices[vertex]] = vertex;
  std::vector<FaceVertices> renumbered;
  for (const FaceId face : faces) {
    FaceVertices& corners = renumbered.emplace_back(file.faces[face]);
    for (VertexId& vertex : corners) vertex = number[vertex];
  }
  const MatchedSides sides = match_sides(renumbered, vertices.size(), "test");
  return answer_of({renumbered, sides.twins, vertices.size(), vertices, faces});
}

}  // namespace

TEST_CASE("RecoverLevels_OtherNumbers_DoNotChangeTheAnswer") {
  std::vector<NamedMesh> meshes = all_meshes();
  meshes.push_back({"torus of valence 6", torus_grid(3, 5)});
  meshes.push_back({"ring", annulus(6)});
  meshes.push_back({"two tori", side_by_side({torus_grid(4, 4), torus_grid(3, 4), icosahedron()})});
  const int levels = GENERATE(0, 1, 2);
  unsigned seed = 0;
  for (const NamedMesh& each : meshes) {
    if (each.mesh.faces.size() << 2 * levels > 20000) continue;
    INFO(each.name << ", " << levels << " levels");
    const Refined fine(each.mesh, levels, ++seed);
    const Answer answer = answer_of(fine.view());
    CHECK(answer.levels.size() >= static_cast<std::size_t>(levels));
    CHECK(answer_with_other_numbers(fine.mesh, seed + 100) == answer);
  }
}
