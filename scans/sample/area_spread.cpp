#include "sample/area_spread.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/threads.h"
#include "sample/samples.h"
#include "surface/surface.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr double kEvenRatio = 4;
constexpr double kMostRatio = 1e12;

/// The value that so large a share of the values does not exceed. Changes their order.
double value_at(std::vector<double>& values, double share) {
  const double place = std::round(share * static_cast<double>(values.size() - 1));
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(place);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

AreaSpread area_spread(const BaseMesh& base, int level,
                       std::span<const Vector3<double>> positions) {
  const SampleNumbers numbers(base, level);
  const auto at = [&](std::uint64_t sample) -> const Point& { return positions[sample]; };
  std::vector<double> ratios(base.face_count());
  each_on_workers(std::size_t{0}, ratios.size(), [&](std::size_t face) {
    std::vector<double> areas;
    areas.reserve(std::size_t{1} << (2 * level));
    numbers.for_each_triangle(static_cast<FaceId>(face),
                              [&](std::uint64_t a, std::uint64_t b, std::uint64_t c) {
                                areas.push_back(length(area_vector(at(a), at(b), at(c))));
                              });
    const double large = value_at(areas, 0.99), small = value_at(areas, 0.01);
    ratios[face] = large < kMostRatio * small ? large / small : kMostRatio;
  });
  const auto even = std::ranges::count_if(ratios, [](double ratio) { return ratio <= kEvenRatio; });
  return {value_at(ratios, 0.9), static_cast<double>(even) / static_cast<double>(ratios.size())};
}

PLAIT_END_NAMESPACE
