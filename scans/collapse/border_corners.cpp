#include "collapse/border_corners.h"

#include <cmath>
#include <cstddef>
#include <numbers>

#include "surface/edge_pairs.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

std::vector<std::uint8_t> border_corners(const Surface& surface) {
  constexpr double kTurn = std::numbers::pi / 6;
  constexpr std::size_t kFewSides = 8;  // a border of so few is drawn
  std::vector<std::uint8_t> corners(surface.positions.size(), 0);
  std::vector<VertexId> sharp;
  for_each_border(surface.faces.size(), surface.across, [&](const std::vector<FaceSide>& border) {
    const auto start = [&](std::size_t at) {
      const FaceSide side = border[at % border.size()];
      return surface.faces[side.face()][static_cast<std::size_t>((side.side() + 1) % 3)];
    };
    sharp.clear();
    std::size_t between = 0;
    for (std::size_t at = 0; at < border.size(); ++at) {
      const VertexId vertex = start(at + 1);
      const Point in = surface.positions[vertex] - surface.positions[start(at)],
                  out = surface.positions[start(at + 2)] - surface.positions[vertex];
      const double turn = std::atan2(length(cross(in, out)), dot(in, out));
      if (turn > kTurn) sharp.push_back(vertex);
      if (turn > kTurn / 2 && turn <= kTurn) ++between;
    }
    if (4 * between > sharp.size()) return;
    if (border.size() > kFewSides && 4 * sharp.size() > border.size()) return;
    for (const VertexId vertex : sharp) corners[vertex] = 1;
  });
  return corners;
}

PLAIT_END_NAMESPACE
