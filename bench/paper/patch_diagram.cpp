#include "paper/patch_diagram.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <iterator>

#include "plait/error.h"
#include "plait/extend/edge_index.h"

namespace plait::paper {
namespace {

constexpr double kWidth = 640, kMargin = 40, kSide = kWidth - 2 * kMargin;
constexpr const char* kEdgeNames[] = {"bc", "ca", "ab"};
// Colours that also people tell apart who do not see red and green.
constexpr const char* kColours[] = {"#d55e00", "#009e73", "#0072b2"};

struct DrawnPoint {
  double x, y;
};

double height() { return kSide * std::sqrt(3.0) / 2; }

DrawnPoint place_of(const FaceIndex& point) {
  const double size = std::exp2(point.level);
  const double i = static_cast<double>(point.i) / size, j = static_cast<double>(point.j) / size;
  return {kMargin + kSide * (i + j / 2), kMargin + height() * (1 - j)};
}

/// Calls visit(SideIndex) for the vertices of the face, coarse levels first.
template <class Visit>
void for_each_vertex(int level, Visit visit) {
  for (int born = 1; born <= level; ++born)
    for (std::int64_t j = 0; j <= std::int64_t{1} << born; ++j)
      for (std::int64_t i = 0; i + j <= std::int64_t{1} << born; ++i)
        if (((i | j) & 1) != 0) visit(to_side(born, i, j));
}

void draw_line(std::string& svg, const SideIndex& child) {
  const DrawnPoint from = place_of(from_side(0, child));
  const DrawnPoint to =
      place_of(from_side(0, {child.side, child.level - 1, child.row / 2, child.column / 2}));
  fmt::format_to(std::back_inserter(svg),
                 "<path class=\"{}\" d=\"M{:.1f} {:.1f}L{:.1f} {:.1f}\"/>\n",
                 kEdgeNames[child.side], from.x, from.y, to.x, to.y);
}

void draw_corner(std::string& svg, int corner, const char* name, double dx, double dy) {
  const DrawnPoint at = place_of(corner_point(0, 0, corner));
  fmt::format_to(std::back_inserter(svg),
                 "<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"12\" height=\"12\" fill=\"#222\"/>\n"
                 "<text x=\"{:.1f}\" y=\"{:.1f}\">{}</text>\n",
                 at.x - 6, at.y - 6, at.x + dx, at.y + dy, name);
}

}  // namespace

std::string patch_diagram(int level) {
  if (level < 1 || level > 6)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("draw a patch: level {}, expected 1 to 6", level));
  std::string svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0:.0f} {1:.0f}\" width=\"{0:.0f}\" "
      "height=\"{1:.0f}\">\n<title>A patch and its three interleaved quadtrees</title>\n<style>\n"
      "text {{ font: 16px sans-serif; fill: #222; text-anchor: middle }}\n"
      "path {{ fill: none; stroke-width: 1.2; opacity: .6 }}\n",
      kWidth, height() + 2 * kMargin);
  for (int side = 0; side < 3; ++side)
    fmt::format_to(std::back_inserter(svg),
                   "circle.{0} {{ fill: {1} }} path.{0} {{ stroke: {1} }}\n", kEdgeNames[side],
                   kColours[side]);
  const DrawnPoint a = place_of(corner_point(0, 0, 0)), b = place_of(corner_point(0, 0, 1)),
                   c = place_of(corner_point(0, 0, 2));
  fmt::format_to(std::back_inserter(svg),
                 "</style>\n<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n"
                 "<polygon points=\"{:.1f},{:.1f} {:.1f},{:.1f} {:.1f},{:.1f}\" fill=\"none\" "
                 "stroke=\"#bbb\"/>\n",
                 a.x, a.y, b.x, b.y, c.x, c.y);
  for_each_vertex(level, [&](const SideIndex& at) {
    if (at.level > 1) draw_line(svg, at);
  });
  for_each_vertex(level, [&](const SideIndex& at) {
    const DrawnPoint place = place_of(from_side(0, at));
    fmt::format_to(std::back_inserter(svg),
                   "<circle class=\"{}\" cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{:.1f}\"/>\n",
                   kEdgeNames[at.side], place.x, place.y, 10 * std::pow(0.72, at.level - 1));
  });
  draw_corner(svg, 0, "a", -18, 18);
  draw_corner(svg, 1, "b", 18, 18);
  draw_corner(svg, 2, "c", 0, -14);
  return svg + "</svg>\n";
}

}  // namespace plait::paper
