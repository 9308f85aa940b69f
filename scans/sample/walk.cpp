#include "sample/walk.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "collapse/patch.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// The most faces that a walk crosses.
constexpr int kMostFaces = 64;

PlaneVector operator-(PlaneVector a, PlaneVector b) { return {a.x - b.x, a.y - b.y}; }
double cross_of(PlaneVector a, PlaneVector b) { return a.x * b.y - a.y * b.x; }

/// A face in the plane, counterclockwise.
using PlaneFace = std::array<PlaneVector, 3>;

/// The third corner of a face to the left of a side from p, in lengths of the side: along it, and
/// away from it.
PlaneVector beside(Point p, Point side, Point corner) {
  const double squared = squared_length(side);
  const Point to_corner = corner - p;
  const double part = dot(to_corner, side) / squared;
  return {part, std::sqrt(squared_length(to_corner - part * side) / squared)};
}

/// The change of the barycentric coordinates along a vector.
std::array<double, 3> change_along(const PlaneFace& face, PlaneVector way) {
  const PlaneVector ab = face[1] - face[0], ac = face[2] - face[0];
  const double area = cross_of(ab, ac);
  if (!(area > 0)) return {0, 0, 0};
  const double b = cross_of(way, ac) / area, c = cross_of(ab, way) / area;
  return {-b - c, b, c};
}

/// Goes until the way ends, or up to a side of the face. Returns the side, or -1, and sets the part
/// of the way that was gone.
int go(std::array<double, 3>& weights, const std::array<double, 3>& change, double& part) {
  part = 1;
  int side = -1;
  for (int i = 0; i < 3; ++i) {
    const auto corner = static_cast<std::size_t>(i);
    if (change[corner] >= 0 || weights[corner] + change[corner] >= 0) continue;
    const double until = std::max(0.0, weights[corner] / -change[corner]);
    if (until < part || side < 0) {
      part = until;
      side = i;
    }
  }
  for (std::size_t i = 0; i < 3; ++i) weights[i] = std::max(0.0, weights[i] + part * change[i]);
  const double sum = weights[0] + weights[1] + weights[2];
  for (double& weight : weights) weight /= sum;
  return side;
}

}  // namespace

Walk::Walk(const Surface& scan, const SurfacePoint& start) : scan_(scan), start_(start) {
  const Point a = scan.corner(start.face, 0), ab = scan.corner(start.face, 1) - a,
              ac = scan.corner(start.face, 2) - a;
  const Point normal = cross(ab, ac);
  const double squared = squared_length(normal);
  const double scale = squared > 0 ? 1 / squared : 0;
  gradients_[1] = scale * cross(ac, normal);
  gradients_[2] = scale * cross(normal, ab);
  gradients_[0] = Point{0, 0, 0} - gradients_[1] - gradients_[2];
}

SurfacePoint Walk::along(Point way) const {
  const std::array<double, 3> change = {dot(gradients_[0], way), dot(gradients_[1], way),
                                        dot(gradients_[2], way)};
  SurfacePoint end = start_;
  for (std::size_t i = 0; i < 3; ++i) end.weights[i] += change[i];
  if (end.weights[0] >= 0 && end.weights[1] >= 0 && end.weights[2] >= 0) return end;
  return across(change);
}

SurfacePoint Walk::across(std::array<double, 3> change) const {
  SurfacePoint at = start_;
  // The faces on the way lie in one plane, as if unfolded. The side ab of the first is its unit.
  const Point a = scan_.corner(at.face, 0), ab = scan_.corner(at.face, 1) - a;
  PlaneFace face = {{{0, 0}, {1, 0}, beside(a, ab, scan_.corner(at.face, 2))}};
  PlaneVector rest = {change[1] + change[2] * face[2].x, change[2] * face[2].y};
  for (int crossed = 0; crossed < kMostFaces; ++crossed) {
    double part = 1;
    const int side = go(at.weights, change, part);
    if (side < 0) return at;
    const FaceSide beyond = scan_.across[FaceSide(at.face, side).code];
    if (!beyond.exists()) return at;
    rest = {(1 - part) * rest.x, (1 - part) * rest.y};
    // The side has its ends in the other order in the other face.
    const int from = (side + 2) % 3, to = (side + 1) % 3;
    const Point p = scan_.corner(at.face, from);
    const PlaneVector apex =
        beside(p, scan_.corner(at.face, to) - p, scan_.corner(beyond.face(), beyond.side()));
    const auto first = static_cast<std::size_t>(from), second = static_cast<std::size_t>(to);
    const PlaneVector start = face[first], unit = face[second] - start;
    const auto corner = static_cast<std::size_t>(beyond.side());
    PlaneFace next;
    next[(corner + 1) % 3] = start;
    next[(corner + 2) % 3] = face[second];
    next[corner] = {start.x + apex.x * unit.x - apex.y * unit.y,
                    start.y + apex.x * unit.y + apex.y * unit.x};
    SurfacePoint there{beyond.face(), {}};
    there.weights[(corner + 1) % 3] = at.weights[first];
    there.weights[(corner + 2) % 3] = at.weights[second];
    face = next;
    at = there;
    change = change_along(face, rest);
  }
  return at;
}

PLAIT_END_NAMESPACE
