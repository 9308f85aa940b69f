// Loop positions and limit positions against the naive oracle in double.
#include "kernels/oracle.h"
#include "plait/error.h"

namespace plait::test {
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
      const SubdivideOptions options{.executor = executor, .levels = levels};
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
  const IndexedMesh mesh = bipyramid(5000);
  const naive::Mesh oracle = naive::subdivide(to_naive(mesh), naive::Scheme::kLoop, 3);
  Store store = refine_in_memory(mesh, {.levels = 3});
  CHECK(worst_distance<Vector3<float>>(store, "position", oracle, oracle.points) < kFloatTolerance);
}

TEST_CASE("LoopLimit_AllTestMeshes_AgreesWithOracle") {
  for (const NamedMesh& named : all_meshes())
    for (const ExecutorKind executor : kExecutors) {
      INFO(named.name << ", executor " << to_string(executor));
      const naive::Mesh oracle = naive::subdivide(to_naive(named.mesh), naive::Scheme::kLoop, 3);
      Store store =
          refine_in_memory(named.mesh, {.executor = executor, .levels = 3, .limit = true}, true);
      CHECK_FALSE(store.has_attribute("limit"));
      CHECK(worst_distance<Vector3<double>>(store, "position", oracle,
                                            naive::loop_limit_points(oracle)) < kDoubleTolerance);
    }
}

TEST_CASE("LoopPositions_RefinedInTwoCalls_AreThoseOfOne") {
  // Fused starts from the base mesh only.
  for (const ExecutorKind executor : {ExecutorKind::kSweep, ExecutorKind::kTransparent}) {
    const IndexedMesh mesh = random_sphere(7, 60);
    SubdivideOptions options{.executor = executor, .levels = 2};
    Store store = refine_in_memory(mesh, options);
    options.levels = 4;
    subdivide(store, options);
    const naive::Mesh oracle = naive::subdivide(to_naive(mesh), naive::Scheme::kLoop, 4);
    CHECK(worst_distance<Vector3<float>>(store, "position", oracle, oracle.points) <
          kFloatTolerance);
  }
}

// Modified Butterfly and midpoint against the naive oracle in double.

namespace {

void compare(Scheme scheme, naive::Scheme oracle_scheme) {
  for (const NamedMesh& named : all_meshes())
    for (const ExecutorKind executor :
         {ExecutorKind::kFused, ExecutorKind::kSweep, ExecutorKind::kTransparent}) {
      const int levels = GENERATE(1, 2, 4);
      INFO(named.name << ", executor " << to_string(executor) << ", level " << levels);
      const naive::Mesh oracle = naive::subdivide(to_naive(named.mesh), oracle_scheme, levels);
      Store store = refine_in_memory(
          named.mesh, {.scheme = scheme, .executor = executor, .levels = levels}, true);
      CHECK(worst_distance<Vector3<double>>(store, "position", oracle, oracle.points) < 1e-13);
    }
}

}  // namespace

TEST_CASE("ButterflyPositions_AllTestMeshes_AgreeWithOracle") {
  compare(Scheme::kButterfly, naive::Scheme::kButterfly);
}

// All three vertices have valence 2, and each new one is the mean of what its two ends say:
// 3/4 v + 3/8 of the neighbour on the edge itself - 1/8 of the other.
TEST_CASE("ButterflyPositions_InteriorValenceTwo_FollowTheFoldedWeightsOfValenceFour") {
  const IndexedMesh mesh = two_faces_back_to_back();
  const auto& [a, b, c] = mesh.faces[0];
  const auto middle = [&](VertexId start, VertexId end, VertexId other) {
    const auto& p = mesh.positions;
    return 0.5625 * (p[start] + p[end]) - 0.125 * p[other];
  };
  for (const ExecutorKind executor :
       {ExecutorKind::kFused, ExecutorKind::kSweep, ExecutorKind::kTransparent}) {
    INFO("executor " << to_string(executor));
    Store store =
        refine_in_memory(mesh, {.scheme = Scheme::kButterfly, .executor = executor}, true);
    StorePatches<Vector3<double>> patches(store, store.attribute("position"), 1 << 20, Reach::kOwn);
    patches.activate(1, 1, 0);
    const auto patch = patches.patch(0);
    CHECK(patch.at(1, 1, 0) == middle(a, b, c));
    CHECK(patch.at(1, 1, 1) == middle(b, c, a));
    CHECK(patch.at(1, 0, 1) == middle(c, a, b));
  }
}

TEST_CASE("MidpointPositions_AllTestMeshes_AgreeWithOracle") {
  compare(Scheme::kMidpoint, naive::Scheme::kMidpoint);
}

TEST_CASE("LimitPositions_WithoutLoop_AreRefused") {
  REQUIRE_THROWS_AS(refine_in_memory(tetrahedron(), {.scheme = Scheme::kButterfly, .limit = true}),
                    Error);
}

TEST_CASE("Rebase_AnyScheme_AgreesWithOracle") {
  for (const auto& [scheme, oracle_scheme] :
       {std::pair(Scheme::kLoop, naive::Scheme::kLoop),
        std::pair(Scheme::kButterfly, naive::Scheme::kButterfly),
        std::pair(Scheme::kMidpoint, naive::Scheme::kMidpoint)})
    for (const IndexedMesh& mesh : {random_sphere(3, 40), random_sheet(5, 40)}) {
      const BaseMesh refined = rebase(BaseMesh::build(mesh), 2, scheme, ComponentType::kFloat64);
      const naive::Mesh oracle = naive::subdivide(to_naive(mesh), oracle_scheme, 2);
      REQUIRE(refined.vertex_count() == oracle.points.size());
      REQUIRE(refined.face_count() == oracle.triangles.size());
      // The numbering of new vertices differs, so the surfaces are compared as sets of triangles.
      using Corners = std::array<std::array<double, 3>, 3>;
      const auto rounded = [](double x, double y, double z) {
        return std::array{std::round(x * 1e9), std::round(y * 1e9), std::round(z * 1e9)};
      };
      const auto canonical = [](Corners corners) {
        std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()),
                    corners.end());
        return corners;
      };
      std::vector<Corners> found, expected;
      for (const auto& face : refined.faces()) {
        Corners corners;
        for (std::size_t k = 0; k < 3; ++k) {
          const Vector3<double>& p = refined.positions()[face[k]];
          corners[k] = rounded(p.x, p.y, p.z);
        }
        found.push_back(canonical(corners));
      }
      for (const naive::Triangle& triangle : oracle.triangles) {
        Corners corners;
        for (std::size_t k = 0; k < 3; ++k) {
          const naive::Point& p = oracle.points[triangle[k]];
          corners[k] = rounded(p.x, p.y, p.z);
        }
        expected.push_back(canonical(corners));
      }
      std::ranges::sort(found);
      std::ranges::sort(expected);
      CHECK(found == expected);
    }
}

}  // namespace plait::test
