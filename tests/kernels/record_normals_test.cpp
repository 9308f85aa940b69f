// Normals of runs of records on every instruction set of this machine: the bits of the scalar rule,
// for runs of every length.
#include "rows/record_normals.h"

#include <array>
#include <cstddef>
#include <vector>

#include "base/regular_normal.h"
#include "kernels/row_points.h"

using namespace plait;
using namespace plait::test;

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
