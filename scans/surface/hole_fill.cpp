#include "surface/hole_fill.h"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr std::size_t kLargestFan = 8;

/// The point of the border at this part of the way around it.
Point border_point(std::span<const Point> border, double part) {
  const double place = part * static_cast<double>(border.size());
  const auto before = static_cast<std::size_t>(place);
  const double rest = place - static_cast<double>(before);
  return (1 - rest) * border[before % border.size()] + rest * border[(before + 1) % border.size()];
}

}  // namespace

HoleFill fill_hole(std::span<const Point> border) {
  HoleFill fill;
  Point middle{0, 0, 0};
  for (const Point& p : border) middle = middle + p;
  middle = (1 / static_cast<double>(border.size())) * middle;
  std::vector<VertexId> outer(border.size()), inner;
  std::iota(outer.begin(), outer.end(), VertexId{0});
  const auto add = [&](Point p) {
    fill.inner.push_back(p);
    return static_cast<VertexId>(border.size() + fill.inner.size() - 1);
  };
  while (outer.size() > kLargestFan) {
    inner.clear();
    const std::size_t many = outer.size(), few = (many + 1) / 2;
    const double radius = static_cast<double>(few) / static_cast<double>(border.size());
    for (std::size_t i = 0; i < few; ++i) {
      const double part = (static_cast<double>(i) + 0.5) / static_cast<double>(few);
      inner.push_back(add(middle + radius * (border_point(border, part) - middle)));
    }
    for (std::size_t i = 0, j = 0; i < many || j < few;) {
      const VertexId at = outer[i % many], here = inner[j % few];
      if (j == few || (i < many && (i + 1) * few <= (j + 1) * many)) {
        fill.faces.push_back({outer[(i + 1) % many], at, here});
        ++i;
      } else {
        fill.faces.push_back({at, here, inner[(j + 1) % few]});
        ++j;
      }
    }
    outer.swap(inner);
  }
  const VertexId last = add(middle);
  for (std::size_t i = 0; i < outer.size(); ++i)
    fill.faces.push_back({outer[(i + 1) % outer.size()], outer[i], last});
  return fill;
}

PLAIT_END_NAMESPACE
