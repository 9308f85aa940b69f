// Levels of a store whose base mesh was refined_again beforehand are those of the given mesh.
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <utility>
#include <vector>

#include "plait/digest.h"
#include "plait/extend/patch.h"
#include "plait/extend/vertex_numbering.h"
#include "plait/layout.h"
#include "plait/registry.h"
#include "plait/subdivide.h"
#include "support/test_meshes.h"

using namespace plait;
using namespace plait::test;

namespace {

using Position = Vector3<float>;
constexpr int kLevels = 5, kTimes = 2;

Store refined_again(const BaseMesh& base, int base_level, SubdivideOptions what) {
  Store store = Store::create({}, base, {}, default_backends(), {.base_level = base_level});
  add_base_positions(store);
  what.levels = kLevels;
  subdivide(store, what);
  return store;
}

/// The corners of a face's triangles at level kTimes, in the order in which rebase() has them.
std::vector<std::array<FacePoint, 3>> faces_of_a_face() {
  std::vector<std::array<FacePoint, 3>> faces;
  for_each_triangle(kTimes,
                    [&](const std::array<FacePoint, 3>& corners) { faces.push_back(corners); });
  return faces;
}

/// The largest distance at `level` between the vertices of a store of `mesh` and those of a store
/// of `mesh` refined_again kTimes, both asked for the same level.
double largest_distance(Store& plain, Store& rebased, int level) {
  StorePatches<Position> expected(plain, plain.attribute("position"), 16 << 20);
  StorePatches<Position> found(rebased, rebased.attribute("position"), 16 << 20);
  expected.activate(level, 1, 0);
  found.activate(level, 1, 0);
  const auto inner = faces_of_a_face();
  double largest = 0;
  for (FaceId face = 0; face < rebased.base().face_count(); ++face) {
    const auto outer_patch = expected.patch(static_cast<FaceId>(face / inner.size()));
    const auto patch = found.patch(face);
    const std::int64_t size = patch.size(level);
    CHECK(size << kTimes == outer_patch.size(level));
    const auto& [a, b, c] = inner[face % inner.size()];
    for (std::int64_t j = 0; j <= size; ++j)
      for (std::int64_t i = 0; i + j <= size; ++i) {
        const std::int64_t k = size - i - j;
        const Position& there =
            outer_patch.at(level, k * a.i + i * b.i + j * c.i, k * a.j + i * b.j + j * c.j);
        const Position apart = patch.at(level, i, j) - there;
        largest = std::max(largest, std::sqrt(double(dot(apart, apart))));
      }
  }
  return largest;
}

}  // namespace

TEST_CASE("PatchAt_StoreOfARebasedMesh_IsTheSameVertexAsWithout") {
  for (const IndexedMesh& mesh : {random_sphere(61, 40), random_sheet(62, 40)}) {
    const BaseMesh base = BaseMesh::build(mesh);
    for (const Scheme scheme : {Scheme::kMidpoint, Scheme::kLoop}) {
      Store plain = refined_again(base, 0, {.scheme = scheme});
      Store rebased = refined_again(rebase(base, kTimes, scheme), kTimes, {.scheme = scheme});
      REQUIRE(rebased.base_level() == kTimes);
      REQUIRE(rebased.finest_level() == kLevels);
      for (int level = kTimes; level <= kLevels; ++level) {
        INFO(to_string(scheme) << " level " << level);
        // Base vertices are moved in double, others in float: Loop's bits differ.
        const double distance = largest_distance(plain, rebased, level);
        CHECK(distance <= (scheme == Scheme::kLoop ? 1e-5 : 0.0));
      }
    }
  }
}

TEST_CASE("Digest_ExecutorsOverARebasedMesh_AreTheSame") {
  const BaseMesh mesh = BaseMesh::build(random_sheet(63, 40));
  for (const Scheme scheme : {Scheme::kLoop, Scheme::kButterfly}) {
    const BaseMesh base = rebase(mesh, kTimes, scheme);
    SubdivideOptions what{.scheme = scheme, .normals = true};
    what.limit = scheme == Scheme::kLoop;
    std::vector<std::string> digests;
    for (const ExecutorKind executor :
         {ExecutorKind::kSweep, ExecutorKind::kTransparent, ExecutorKind::kFused}) {
      what.executor = executor;
      std::vector<std::string> phases;
      what.progress = [&](const Progress& progress) {
        phases.emplace_back(progress.phase);
        return true;
      };
      Store store = refined_again(base, kTimes, what);
      digests.push_back(digest(store).to_string());
      for (const std::string& phase : phases)  // "level 1" and "level 2" are in memory
        CHECK((phase.find("level 1") != 0 && phase.find("level 2") != 0));
    }
    CHECK(digests[1] == digests[0]);
    CHECK(digests[2] == digests[0]);
  }
}

TEST_CASE("Rebase_OfAMeshInAnotherOrder_MapsNameTheFaceThatWasDivided") {
  IndexedMesh input = random_sheet(5, 60);
  std::swap(input.faces[1][1], input.faces[1][2]);
  input.positions.push_back({9, 9, 9});  // no face uses it
  const BaseMesh base = lay_out(BaseMesh::build(input), LayoutKind::kHilbert).mesh;
  const BaseMesh mesh =
      lay_out(rebase(base, 2, scheme_from_name("midpoint")), LayoutKind::kRcm).mesh;
  const InputMaps maps = mesh.input_maps();
  std::vector<int> parts(input.faces.size());
  for (const FaceId face : maps.input_faces) ++parts[face];
  for (const int count : parts) REQUIRE(count == 16);
  int of_input = 0;
  for (VertexId vertex = 0; vertex < mesh.vertex_count(); ++vertex) {
    if (maps.input_vertices[vertex] == kNoId) continue;
    ++of_input;
    // Midpoint moves no vertex but rounds to float32.
    const Vector3<double>& there = input.positions[maps.input_vertices[vertex]];
    REQUIRE(mesh.positions()[vertex].x == static_cast<float>(there.x));
  }
  CHECK(of_input == static_cast<int>(base.vertex_count()));
  for (FaceId face = 0; face < input.faces.size(); ++face) {
    REQUIRE(maps.input_faces[maps.faces[face]] == face);
    for (FaceId before = 0; before < maps.faces[face]; ++before)
      REQUIRE(maps.input_faces[before] != face);
  }
  CHECK(maps.turned[maps.faces[1]]);
  CHECK_FALSE(maps.turned[maps.faces[0]]);
}
