#include "sample/exact_faces.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "base/threads.h"
#include "surface/paced_ranges.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// Of the largest coordinate: a distance that is rounding.
constexpr double kRoundingShare = 1e-13;
constexpr std::size_t kFacesJudgedAtOnce = 16;

}  // namespace

std::vector<std::uint8_t> exact_faces(const Surface& scan, const TriangleTree& tree,
                                      const BaseMesh& base, int level,
                                      const std::vector<SurfacePoint>& samples,
                                      const std::function<void()>& go_on) {
  double largest = 0;
  for (const Point& p : scan.positions)
    largest = std::max({largest, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
  const double most = kRoundingShare * kRoundingShare * largest * largest;
  const SampleNumbers numbers(base, level);
  std::vector<std::uint8_t> exact(base.face_count(), 1);
  const auto judge = [&](FaceId face) {
    numbers.for_each_triangle(face, [&](std::uint64_t a, std::uint64_t b, std::uint64_t c) {
      if (exact[face] == 0) return;
      constexpr double kNear = 2.0 / 3, kFar = 1.0 / 6;
      const std::array<SurfacePoint, 3> corners = {samples[a], samples[b], samples[c]};
      std::array<Point, 3> at;
      for (std::size_t i = 0; i < 3; ++i) at[i] = position_of(scan, corners[i]);
      for (std::size_t i = 0; i < 3; ++i) {
        const Point p = kNear * at[i] + kFar * at[(i + 1) % 3] + kFar * at[(i + 2) % 3];
        if (tree.closest(p, corners[i].face).squared_distance <= most) continue;
        exact[face] = 0;
        return;
      }
    });
  };
  for_paced_ranges(
      exact.size(), {kFacesJudgedAtOnce},
      [&](std::size_t) {
        if (go_on) go_on();
      },
      [&](std::size_t begin, std::size_t end) {
        ranges_on_workers(end - begin, kFacesJudgedAtOnce,
                          [&](std::size_t first, std::size_t last) {
                            for (std::size_t face = begin + first; face < begin + last; ++face)
                              judge(static_cast<FaceId>(face));
                          });
      });
  return exact;
}

PLAIT_END_NAMESPACE
