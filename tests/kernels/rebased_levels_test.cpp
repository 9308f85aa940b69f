// Levels of a store whose base mesh was refined_again beforehand are those of the given mesh.
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "plait/backends/registry.h"
#include "plait/digest.h"
#include "plait/kernels/subdivide.h"
#include "plait/patch.h"
#include "plait/vertex_numbering.h"
#include "support/test_meshes.h"

using namespace plait;
using namespace plait::test;

namespace {

using Position = Vector3<float>;
constexpr int kLevels = 5, kTimes = 2;

Store refined_again(const BaseMesh& base, int base_level, SubdivideOptions what) {
  Store store =
      Store::create({}, base, {.backend = "memory", .base_level = base_level}, default_backends());
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
      what.proceed = [&](const SubdivideProgress& progress) {
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
