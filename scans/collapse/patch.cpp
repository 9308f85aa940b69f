#include "collapse/patch.h"

#include <algorithm>
#include <cmath>
#include <numbers>

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// No face in the plane may be thinner than this, or than a third of what it is in space.
constexpr double kNeedle = 0.02;
constexpr double kLeastQuality = 1e-5;
/// An angle of the fan in the plane may be at most this.
constexpr double kWidestAngle = 0.95 * std::numbers::pi;

enum class Weights : std::uint8_t { kCotangent, kMeanValue, kEqual };

double plane_quality(PlanePoint a, PlanePoint b, PlanePoint c) {
  const double abx = double{b.x} - a.x, aby = double{b.y} - a.y;
  const double acx = double{c.x} - a.x, acy = double{c.y} - a.y;
  const double bcx = double{c.x} - b.x, bcy = double{c.y} - b.y;
  return triangle_quality(abx * acy - aby * acx,
                          abx * abx + aby * aby + acx * acx + acy * acy + bcx * bcx + bcy * bcy);
}

double space_quality(Point a, Point b, Point c) {
  return triangle_quality(length(area_vector(a, b, c)),
                          squared_length(b - a) + squared_length(c - b) + squared_length(a - c));
}

bool fits(PlanePoint a, PlanePoint b, PlanePoint c, double quality) {
  return plane_quality(a, b, c) > std::max(kLeastQuality, std::min(kNeedle, quality / 3));
}

/// The weights of the two other corners b and c of a face as seen from its corner a.
std::array<double, 2> weights_of(Weights kind, Point a, Point b, Point c) {
  const Point ab = b - a, ac = c - a, bc = c - b;
  const double area = length(cross(ab, ac));
  if (kind == Weights::kEqual || !(area > 0)) return {0.5, 0.5};
  // The cotangent at c belongs to the edge ab, that at b to ac.
  if (kind == Weights::kCotangent) return {dot(ac, bc) / area, -dot(ab, bc) / area};
  const double to_b = length(ab), to_c = length(ac);
  const double half_tangent = (to_b * to_c - dot(ab, ac)) / area;
  return {half_tangent / to_b, half_tangent / to_c};
}

bool ring_in_plane(const Patch& patch, const PatchShape& shape, PatchPlane& plane) {
  const int count = patch.ring_size();
  std::array<double, kMaxFan + 1> angle{}, distance{};
  double sum = 0, mean = 0;
  for (int i = 0; i < count; ++i) {
    const auto at = static_cast<std::size_t>(i);
    distance[at] = length(shape.ring[at] - shape.now);
    if (!(distance[at] > 0)) return false;
    mean += distance[at] / count;
  }
  for (int i = 0; i < patch.faces; ++i) {
    const auto at = static_cast<std::size_t>(i), after = static_cast<std::size_t>(patch.next(i));
    const Point a = shape.ring[at] - shape.now, b = shape.ring[after] - shape.now;
    angle[at] = std::atan2(length(cross(a, b)), dot(a, b));
    sum += angle[at];
  }
  if (!(sum > 0)) return false;
  const double scale = (patch.closed ? 2 : 1) * std::numbers::pi / sum;
  const double power = std::clamp(scale, 0.5, 2.0);
  // A crease through the new vertex is straight: half a turn is on each side of it.
  const bool has_line = patch.crease_at_kept >= 0;
  double scale_here = scale, scale_beyond = scale;
  if (has_line) {
    double half = 0;
    for (int i = patch.crease_at_gone; i != patch.crease_at_kept; i = patch.next(i))
      half += angle[static_cast<std::size_t>(i)];
    if (!(half > 0 && half < sum)) return false;
    scale_here = std::numbers::pi / half;
    scale_beyond = std::numbers::pi / (sum - half);
  }
  double turn = 0;
  for (int step = 0, i = patch.closed ? std::max(patch.crease_at_gone, 0) : 0; step < count;
       ++step, i = patch.next(i)) {
    if (has_line && i == patch.crease_at_kept) scale_here = scale_beyond;
    const auto at = static_cast<std::size_t>(i);
    const double radius = std::pow(distance[at] / mean, power);
    plane.ring[at] = {static_cast<float>(radius * std::cos(turn)),
                      static_cast<float>(radius * std::sin(turn))};
    if (i < patch.faces && angle[at] * scale_here > kWidestAngle) return false;
    turn += angle[at] * scale_here;
  }
  if (has_line) {
    plane.ring[static_cast<std::size_t>(patch.crease_at_gone)].y = 0;
    plane.ring[static_cast<std::size_t>(patch.crease_at_kept)].y = 0;
  }
  if (patch.closed) return true;
  // The border is a straight line through the new vertex, without rounding.
  plane.ring[0].y = 0;
  plane.ring[static_cast<std::size_t>(patch.faces)].y = 0;
  return true;
}

/// One equation: total * (the vertex) = sum + to_other * (the other vertex).
struct Equation {
  double total = 0, to_other = 0;
  PlaneVector sum{};

  void add(double weight, PlanePoint neighbour) {
    total += weight;
    sum.x += weight * neighbour.x;
    sum.y += weight * neighbour.y;
  }
  void add_other(double weight) {
    total += weight;
    to_other += weight;
  }
};

void place_on_border(const Patch& patch, const PatchShape& shape, PatchPlane& plane) {
  const auto last = static_cast<std::size_t>(patch.faces);
  const double first = plane.ring[0].x, width = double{plane.ring[last].x} - first;
  const double a = length(shape.gone - shape.ring[0]), b = length(shape.kept - shape.gone),
               c = length(shape.ring[last] - shape.kept);
  // The new vertex is at the origin.
  double gone = first + width * a / (a + b + c), kept = first + width * (a + b) / (a + b + c);
  if (shape.anchor == Anchor::kKept) gone = first * b / (a + b), kept = 0;
  if (shape.anchor == Anchor::kGone) kept = (first + width) * b / (b + c), gone = 0;
  plane.gone = {static_cast<float>(gone), 0};
  plane.kept = {static_cast<float>(kept), 0};
}

void place_on_crease(const Patch& patch, const PatchShape& shape, PatchPlane& plane) {
  const auto after = static_cast<std::size_t>(patch.crease_at_gone);
  const double b = length(shape.gone - shape.kept), c = length(shape.ring[after] - shape.gone);
  if (patch.kept_stays) {  // a corner, at the origin
    const double part = b / (b + c);
    plane.gone = {static_cast<float>(part * plane.ring[after].x),
                  static_cast<float>(part * plane.ring[after].y)};
    plane.kept = {0, 0};
    return;
  }
  const auto before = static_cast<std::size_t>(patch.crease_at_kept);
  const double first = plane.ring[before].x, width = double{plane.ring[after].x} - first;
  const double a = length(shape.kept - shape.ring[before]);
  plane.kept = {static_cast<float>(first + width * a / (a + b + c)), 0};
  plane.gone = {static_cast<float>(first + width * (a + b) / (a + b + c)), 0};
}

bool place_inside(const Patch& patch, const PatchShape& shape, Weights kind, PatchPlane& plane) {
  Equation kept, gone;
  for (int i = 0; i < patch.faces; ++i) {
    const auto at = static_cast<std::size_t>(i), after = static_cast<std::size_t>(patch.next(i));
    const bool at_gone = patch.is_at_gone(i);
    const auto weights =
        weights_of(kind, at_gone ? shape.gone : shape.kept, shape.ring[at], shape.ring[after]);
    Equation& equation = at_gone ? gone : kept;
    equation.add(weights[0], plane.ring[at]);
    equation.add(weights[1], plane.ring[after]);
  }
  for (int i = 0; i < patch.lost_faces; ++i) {
    const auto apex = static_cast<std::size_t>(patch.apex[static_cast<std::size_t>(i)]);
    const auto from_kept = weights_of(kind, shape.kept, shape.gone, shape.ring[apex]);
    kept.add_other(from_kept[0]);
    kept.add(from_kept[1], plane.ring[apex]);
    const auto from_gone = weights_of(kind, shape.gone, shape.kept, shape.ring[apex]);
    gone.add_other(from_gone[0]);
    gone.add(from_gone[1], plane.ring[apex]);
  }
  PlaneVector k, g;
  if (!patch.kept_stays) {
    const double determinant = kept.total * gone.total - kept.to_other * gone.to_other;
    if (!(determinant > 0)) return false;
    k = {(gone.total * kept.sum.x + kept.to_other * gone.sum.x) / determinant,
         (gone.total * kept.sum.y + kept.to_other * gone.sum.y) / determinant};
    g = {(kept.total * gone.sum.x + gone.to_other * kept.sum.x) / determinant,
         (kept.total * gone.sum.y + gone.to_other * kept.sum.y) / determinant};
  } else {
    if (!(gone.total > 0)) return false;
    g = {gone.sum.x / gone.total, gone.sum.y / gone.total};
  }
  plane.kept = {static_cast<float>(k.x), static_cast<float>(k.y)};
  plane.gone = {static_cast<float>(g.x), static_cast<float>(g.y)};
  return true;
}

bool all_fit(const Patch& patch, const PatchShape& shape, const PatchPlane& plane) {
  for (int i = 0; i < patch.faces; ++i) {
    const auto at = static_cast<std::size_t>(i), after = static_cast<std::size_t>(patch.next(i));
    const bool at_gone = patch.is_at_gone(i);
    const Point old = at_gone ? shape.gone : shape.kept;
    if (!fits(at_gone ? plane.gone : plane.kept, plane.ring[at], plane.ring[after],
              space_quality(old, shape.ring[at], shape.ring[after])))
      return false;
  }
  for (int i = 0; i < patch.lost_faces; ++i) {
    const auto apex = static_cast<std::size_t>(patch.apex[static_cast<std::size_t>(i)]);
    const double quality = space_quality(shape.kept, shape.gone, shape.ring[apex]);
    if (i == 0 ? !fits(plane.kept, plane.gone, plane.ring[apex], quality)
               : !fits(plane.gone, plane.kept, plane.ring[apex], quality))
      return false;
  }
  return true;
}

}  // namespace

std::optional<PatchPlane> lay_out(const Patch& patch, const PatchShape& shape) {
  PatchPlane plane;
  if (!ring_in_plane(patch, shape, plane)) return {};
  for (int i = 0; i < patch.faces; ++i) {
    const auto at = static_cast<std::size_t>(i), after = static_cast<std::size_t>(patch.next(i));
    if (!fits({0, 0}, plane.ring[at], plane.ring[after],
              space_quality(shape.now, shape.ring[at], shape.ring[after])))
      return {};
  }
  if (patch.border_edge) {
    place_on_border(patch, shape, plane);
    if (all_fit(patch, shape, plane)) return plane;
    return {};
  }
  if (patch.crease_edge) {
    place_on_crease(patch, shape, plane);
    if (all_fit(patch, shape, plane)) return plane;
    return {};
  }
  for (const Weights kind : {Weights::kCotangent, Weights::kMeanValue, Weights::kEqual})
    if (place_inside(patch, shape, kind, plane) && all_fit(patch, shape, plane)) return plane;
  return {};
}

PLAIT_END_NAMESPACE
