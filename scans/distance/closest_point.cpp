#include "distance/closest_point.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/interruption.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr std::uint32_t kFacesBetweenCalls = 10000;
constexpr std::uint32_t kLeafFaces = 4;

float rounded_down(double value) {
  const auto near = static_cast<float>(value);
  return double{near} <= value ? near
                               : std::nextafter(near, -std::numeric_limits<float>::infinity());
}

/// A box may reach beyond its triangles, but not the other way: what the subtraction of `origin`
/// rounds is less than the next number of float.
float low_of_box(double value, double origin) {
  const float low = rounded_down(value - origin);
  return origin == 0 ? low : std::nextafter(low, -std::numeric_limits<float>::infinity());
}

float high_of_box(double value, double origin) { return -low_of_box(-value, -origin); }

template <class Node>
double squared_distance_to_box(Point p, const Node& node) {
  double sum = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const auto at = static_cast<std::size_t>(axis);
    const double out =
        std::max({double{node.low[at]} - p[axis], 0.0, p[axis] - double{node.high[at]}});
    sum += out * out;
  }
  return sum;
}

}  // namespace

Point closest_of_triangle(Point p, Point a, Point b, Point c) {
  const Point ab = b - a, ac = c - a, ap = p - a;
  const double d1 = dot(ab, ap), d2 = dot(ac, ap);
  if (d1 <= 0 && d2 <= 0) return a;
  const Point bp = p - b;
  const double d3 = dot(ab, bp), d4 = dot(ac, bp);
  if (d3 >= 0 && d4 <= d3) return b;
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0 && d1 > d3) return a + (d1 / (d1 - d3)) * ab;
  const Point cp = p - c;
  const double d5 = dot(ab, cp), d6 = dot(ac, cp);
  if (d6 >= 0 && d5 <= d6) return c;
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0 && d2 > d6) return a + (d2 / (d2 - d6)) * ac;
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 >= d3 && d5 >= d6 && d4 - d3 + (d5 - d6) > 0)
    return b + ((d4 - d3) / (d4 - d3 + (d5 - d6))) * (c - b);
  const double sum = va + vb + vc;
  return sum > 0 ? a + (vb / sum) * ab + (vc / sum) * ac : a;
}

TriangleTree::TriangleTree(std::span<const Point> positions,
                           std::span<const std::array<VertexId, 3>> faces,
                           const std::function<void()>& go_on)
    : positions_(positions), faces_(faces), order_(faces.size()) {
  std::iota(order_.begin(), order_.end(), FaceId{0});
  std::vector<Point> middles(faces.size());
  for (std::size_t face = 0; face < faces.size(); ++face)
    middles[face] =
        positions[faces[face][0]] + positions[faces[face][1]] + positions[faces[face][2]];
  nodes_.reserve(faces.size());
  choose_origin();
  build(0, static_cast<std::uint32_t>(faces.size()), middles, go_on);
}

void TriangleTree::choose_origin() {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < 3; ++axis) {
    double low = kInfinity, high = -kInfinity;
    for (const std::array<VertexId, 3>& face : faces_)
      for (const VertexId vertex : face) {
        low = std::min(low, positions_[vertex][axis]);
        high = std::max(high, positions_[vertex][axis]);
      }
    const double middle = low / 2 + high / 2;
    if (std::abs(middle) > high - low) origin_[axis] = middle;
  }
}

void TriangleTree::build(std::uint32_t first, std::uint32_t count, std::vector<Point>& middles,
                         const std::function<void()>& go_on) {
  if (count > kFacesBetweenCalls) {
    if (go_on) go_on();
    poll_interruption();
  }
  const std::size_t at = nodes_.size();
  nodes_.emplace_back();
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Point low{kInfinity, kInfinity, kInfinity}, high{-kInfinity, -kInfinity, -kInfinity};
  Point low_middle = low, high_middle = high;
  for (std::uint32_t i = first; i < first + count; ++i) {
    for (const VertexId vertex : faces_[order_[i]])
      for (int axis = 0; axis < 3; ++axis) {
        low[axis] = std::min(low[axis], positions_[vertex][axis]);
        high[axis] = std::max(high[axis], positions_[vertex][axis]);
      }
    for (int axis = 0; axis < 3; ++axis) {
      low_middle[axis] = std::min(low_middle[axis], middles[order_[i]][axis]);
      high_middle[axis] = std::max(high_middle[axis], middles[order_[i]][axis]);
    }
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto of_axis = static_cast<int>(axis);
    nodes_[at].low[axis] = low_of_box(low[of_axis], origin_[of_axis]);
    nodes_[at].high[axis] = high_of_box(high[of_axis], origin_[of_axis]);
  }
  if (count <= kLeafFaces) {
    nodes_[at].first = first;
    nodes_[at].count = count;
    return;
  }
  int axis = 0;
  for (int other = 1; other < 3; ++other)
    if (high_middle[other] - low_middle[other] > high_middle[axis] - low_middle[axis]) axis = other;
  const std::uint32_t half = count / 2;
  std::nth_element(
      order_.begin() + first, order_.begin() + first + half, order_.begin() + first + count,
      [&](FaceId a, FaceId b) {
        return middles[a][axis] != middles[b][axis] ? middles[a][axis] < middles[b][axis] : a < b;
      });
  build(first, half, middles, go_on);
  nodes_[at].first = static_cast<std::uint32_t>(nodes_.size());
  nodes_[at].count = 0;
  build(first + half, count - half, middles, go_on);
}

void TriangleTree::offer(Point p, FaceId face, ClosestPoint& best) const {
  const auto& [a, b, c] = faces_[face];
  const Point near = closest_of_triangle(p, positions_[a], positions_[b], positions_[c]);
  const double squared = squared_length(near - p);
  if (squared < best.squared_distance || (squared == best.squared_distance && face < best.face))
    best = {near, squared, face};
}

ClosestPoint TriangleTree::closest(Point p, FaceId hint) const {
  ClosestPoint best;
  offer(p, hint, best);
  struct Waiting {
    std::uint32_t node;
    double squared_distance;
  };
  const Point at = p - origin_;
  std::array<Waiting, 64> stack;  // halves of halves: at most 32 levels
  std::size_t depth = 0;
  stack[depth++] = {0, squared_distance_to_box(at, nodes_[0])};
  while (depth > 0) {
    const Waiting next = stack[--depth];
    if (next.squared_distance > best.squared_distance) continue;
    const Node& node = nodes_[next.node];
    if (node.count > 0) {
      for (std::uint32_t i = node.first; i < node.first + node.count; ++i)
        offer(p, order_[i], best);
      continue;
    }
    Waiting near = {next.node + 1, squared_distance_to_box(at, nodes_[next.node + 1])};
    Waiting far = {node.first, squared_distance_to_box(at, nodes_[node.first])};
    if (far.squared_distance < near.squared_distance) std::swap(near, far);
    if (far.squared_distance <= best.squared_distance) stack[depth++] = far;
    if (near.squared_distance <= best.squared_distance) stack[depth++] = near;
  }
  return best;
}

TriangleTree::Box TriangleTree::box_around(const std::array<Point, 3>& points) const {
  Box box{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto of_axis = static_cast<int>(axis);
    const auto [least, most] =
        std::minmax({points[0][of_axis], points[1][of_axis], points[2][of_axis]});
    box.low[axis] = low_of_box(least, origin_[of_axis]);
    box.high[axis] = high_of_box(most, origin_[of_axis]);
  }
  return box;
}

PLAIT_END_NAMESPACE
