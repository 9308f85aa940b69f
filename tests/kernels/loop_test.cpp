// Loop positions and limit positions against the naive oracle in double.
#include "kernels/oracle.h"

using namespace plait;
using namespace plait::test;

namespace {

/// One unit in the last place of a float32 coordinate is 1.2e-7 of it; an even vertex is rounded
/// a few times a level, and averaging damps what the levels before have left.
constexpr double kFloatTolerance = 1e-6;
constexpr double kDoubleTolerance = 1e-14;

const ExecutorKind kExecutors[] = {ExecutorKind::kFused, ExecutorKind::kSweep,
                                   ExecutorKind::kTransparent};

}  // namespace

TEST_CASE("LoopPositions_AllTestMeshes_AgreeWithOracle") {
  for (const NamedMesh& named : all_meshes()) {
    for (const ExecutorKind executor : kExecutors) {
      const int levels = GENERATE(1, 2, 4);
      INFO(named.name << ", executor " << to_string(executor) << ", level " << levels);
      SubdivideOptions options;
      options.executor = executor;
      options.levels = levels;
      const naive::Mesh oracle =
          naive::subdivide(to_naive(named.mesh), naive::Scheme::kLoop, levels);
      Store store = refine_in_memory(named.mesh, options);
      CHECK(worst_distance<Vector3<float>>(store, "position", oracle, oracle.points) <
            kFloatTolerance);
      Store precise = refine_in_memory(named.mesh, options, true);
      CHECK(worst_distance<Vector3<double>>(precise, "position", oracle, oracle.points) <
            kDoubleTolerance);
    }
  }
}

TEST_CASE("LoopPositions_ValenceOfThousands_AgreeWithOracle") {
  SubdivideOptions options;
  options.levels = 3;
  const IndexedMesh mesh = bipyramid(5000);
  const naive::Mesh oracle = naive::subdivide(to_naive(mesh), naive::Scheme::kLoop, 3);
  Store store = refine_in_memory(mesh, options);
  CHECK(worst_distance<Vector3<float>>(store, "position", oracle, oracle.points) < kFloatTolerance);
}

TEST_CASE("LoopLimit_AllTestMeshes_AgreesWithOracle") {
  for (const NamedMesh& named : all_meshes())
    for (const ExecutorKind executor : kExecutors) {
      INFO(named.name << ", executor " << to_string(executor));
      SubdivideOptions options;
      options.executor = executor;
      options.levels = 3;
      options.limit = true;
      const naive::Mesh oracle = naive::subdivide(to_naive(named.mesh), naive::Scheme::kLoop, 3);
      Store store = refine_in_memory(named.mesh, options, true);
      CHECK_FALSE(store.has_attribute("limit"));
      CHECK(worst_distance<Vector3<double>>(store, "position", oracle,
                                            naive::loop_limit_points(oracle)) < kDoubleTolerance);
    }
}

TEST_CASE("LoopPositions_RefinedInTwoCalls_AreThoseOfOne") {
  // Fused starts from the base mesh only.
  for (const ExecutorKind executor : {ExecutorKind::kSweep, ExecutorKind::kTransparent}) {
    const IndexedMesh mesh = random_sphere(7, 60);
    SubdivideOptions options;
    options.executor = executor;
    options.levels = 2;
    Store store = refine_in_memory(mesh, options);
    options.levels = 4;
    subdivide(store, options);
    const naive::Mesh oracle = naive::subdivide(to_naive(mesh), naive::Scheme::kLoop, 4);
    CHECK(worst_distance<Vector3<float>>(store, "position", oracle, oracle.points) <
          kFloatTolerance);
  }
}
