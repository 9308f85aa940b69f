// Normals against the naive oracle in double.
#include <array>
#include <cstddef>
#include <vector>

#include "base/regular_normal.h"
#include "kernels/oracle.h"
#include "kernels/row_points.h"
#include "rows/record_normals.h"

namespace plait::test {
namespace {

/// Angles between the store's normals and the oracle's, where the oracle has one.
struct Angles {
  double worst = 0, sum_of_squares = 0;
  std::uint64_t count = 0;
  double rms() const { return std::sqrt(sum_of_squares / static_cast<double>(count)); }
};

Angles measure_angles(Store& store, const naive::Mesh& oracle) {
  Angles angles;
  const std::vector<naive::Point> expected = naive::loop_limit_normals(oracle);
  for_each_vertex<Vector3<float>>(
      store, "normal", oracle, [&](naive::Index vertex, const Vector3<float>& found) {
        if (naive::length(expected[vertex]) < 0.5) return;
        const double angle = naive::angle_between(expected[vertex], point_of(found));
        angles.worst = std::max(angles.worst, angle);
        angles.sum_of_squares += angle * angle;
        ++angles.count;
      });
  return angles;
}

/// All but the torus whose seven vertices are all neighbours of each other: its limit surface
/// shrinks to a fold, whose tangents are differences of nearly equal numbers.
std::vector<NamedMesh> meshes_with_normals() {
  std::vector<NamedMesh> meshes = all_meshes();
  std::erase_if(meshes, [](const NamedMesh& named) { return named.name == "seven_vertex_torus"; });
  REQUIRE(meshes.size() + 1 == all_meshes().size());
  return meshes;
}

}  // namespace

TEST_CASE("Normals_FromDoublePositions_AgreeWithOracle") {
  for (const NamedMesh& named : meshes_with_normals())
    for (const ExecutorKind executor :
         {ExecutorKind::kFused, ExecutorKind::kSweep, ExecutorKind::kTransparent}) {
      INFO(named.name << ", executor " << to_string(executor));
      const naive::Mesh oracle = naive::subdivide(to_naive(named.mesh), naive::Scheme::kLoop, 3);
      Store store =
          refine_in_memory(named.mesh, {.executor = executor, .levels = 3, .normals = true}, true);
      const Angles angles = measure_angles(store, oracle);
      REQUIRE(angles.count > 0);
      // Stored as float32: half a unit in the last place of each component.
      CHECK(angles.worst < 2e-7);
    }
}

TEST_CASE("Normals_FromFloatPositions_StayWithinTheRoundingOfPositions") {
  for (const NamedMesh& named : meshes_with_normals()) {
    INFO(named.name);
    const naive::Mesh oracle = naive::subdivide(to_naive(named.mesh), naive::Scheme::kLoop, 3);
    Store store = refine_in_memory(named.mesh, {.levels = 3, .normals = true});
    CHECK(measure_angles(store, oracle).rms() < 1e-4);
  }
}

TEST_CASE("Normals_TinyAndHugeUnits_AreOfUnitLength") {
  for (const double scale : {1e-12, 1e12}) {
    IndexedMesh mesh = icosahedron();
    for (Vector3<double>& position : mesh.positions) position = scale * position;
    Store store = refine_in_memory(mesh, {.levels = 3, .normals = true});
    const naive::Mesh oracle = naive::subdivide(to_naive(mesh), naive::Scheme::kLoop, 3);
    CHECK(measure_angles(store, oracle).rms() < 1e-4);
  }
}

// Products of such numbers leave the range of float, or of double.
TEST_CASE("Normals_UnitsWhoseProductsHaveNoNumber_AreThoseOfTheSameShape") {
  const naive::Mesh oracle = naive::subdivide(to_naive(icosahedron()), naive::Scheme::kLoop, 3);
  for (const ExecutorKind executor :
       {ExecutorKind::kFused, ExecutorKind::kSweep, ExecutorKind::kTransparent})
    for (const double scale :
         {1e-30, 1e-23, 1e-19, 1e19, 1e20, 1e36, 1e-300, 1e-160, 1e-100, 1e78, 1e160, 1e300}) {
      CAPTURE(to_string(executor), scale);
      const bool is_double = std::abs(std::log10(scale)) > 37;
      IndexedMesh mesh = icosahedron();
      for (Vector3<double>& position : mesh.positions) position = scale * position;
      Store store =
          refine_in_memory(mesh, {.executor = executor, .levels = 3, .normals = true}, is_double);
      CHECK(measure_angles(store, oracle).rms() < 1e-4);
    }
}

// Normals of runs of records on every instruction set of this machine: the bits of the scalar rule,
// for runs of every length.

namespace {

constexpr std::size_t kMostRecords = 2 * kPatchLanes + 3;
constexpr std::size_t kWidth = kMostRecords + kPatchLanes;  // that many more are read

template <class Real>
void check_run(Points<Real>& points, std::size_t count) {
  const auto* const records = reinterpret_cast<const Vector3<Real>*>(points.first);
  const auto row = [&](std::size_t number) { return records + number * kWidth; };
  constexpr Vector3<float> kGuard{7, 8, 9};
  std::vector<Vector3<float>> normals(count + 1, kGuard);
  record_normals_row<Real>()({{{row(0), row(1)}, {row(2), row(3)}, {row(4), row(5)}},
                              static_cast<std::int64_t>(count),
                              normals.data()});
  bool same = true;
  for (std::size_t i = 0; i < count; ++i) {
    const Vector3<float> expected = RegularNormal::interior(
        row(0)[i] - row(1)[i], row(2)[i] - row(3)[i], row(4)[i] - row(5)[i]);
    for (int axis = 0; axis < 3; ++axis) same &= same_bits(normals[i][axis], expected[axis]);
  }
  CHECK(same);
  CHECK(normals[count] == kGuard);
}

template <class Real>
void check_all_runs() {
  constexpr std::size_t kPoints = 6 * kWidth * 3 / kPointNumbers + 1;
  on_every_target([&] {
    for_all_points<Real>(kPoints, [&](Points<Real>& points) {
      for (std::size_t count = 0; count <= kMostRecords; ++count) check_run(points, count);
    });
    // Many normals along an axis: their zeros are positive.
    for (unsigned seed = 0; seed < 200; ++seed) {
      Points<Real> points(kPoints);
      fill(points, kPoints, seed, Real(1), false);
      check_run(points, kMostRecords);
    }
  });
}

}  // namespace

TEST_CASE("RecordNormals_OfFloatsOnEveryTarget_HaveTheBitsOfTheRuleOfOneVertex") {
  check_all_runs<float>();
}

TEST_CASE("RecordNormals_OfDoublesOnEveryTarget_HaveTheBitsOfTheRuleOfOneVertex") {
  check_all_runs<double>();
}

}  // namespace plait::test
