#include "mesh/files/polygon_ears.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

using Triangles = std::span<const std::array<VertexId, 3>>;

struct PlanePoint {
  double u = 0, v = 0;
  bool operator==(const PlanePoint&) const = default;
};

/// The exact sum of doubles as doubles that do not overlap, the smallest first (J. Shewchuk, 1997,
/// "grow expansion").
class ExactSum {
 public:
  void add(double number) {
    double carry = number;
    for (std::size_t at = 0; at < count_; ++at) {
      const double sum = carry + parts_[at];
      const double other = sum - carry;
      parts_[at] = (carry - (sum - other)) + (parts_[at] - other);
      carry = sum;
    }
    parts_[count_++] = carry;
  }
  void add_product(double a, double b) {
    const double product = a * b;
    add(std::fma(a, b, -product));
    add(product);
  }
  int sign() const {
    for (std::size_t at = count_; at-- > 0;)
      if (parts_[at] != 0) return parts_[at] > 0 ? 1 : -1;
    return 0;
  }

 private:
  std::array<double, 12> parts_{};
  std::size_t count_ = 0;
};

/// The sign of the area of a triangle: 1 if its corners are counterclockwise.
int turn(PlanePoint a, PlanePoint b, PlanePoint c) {
  constexpr double kErrorBound = 3.3306690738754716e-16;  // Shewchuk's ccwerrboundA
  const double left = (a.u - c.u) * (b.v - c.v), right = (a.v - c.v) * (b.u - c.u);
  const double area = left - right;
  if (std::abs(area) > kErrorBound * (std::abs(left) + std::abs(right))) return area > 0 ? 1 : -1;
  ExactSum sum;
  sum.add_product(a.u, b.v);
  sum.add_product(-a.u, c.v);
  sum.add_product(-c.u, b.v);
  sum.add_product(-a.v, b.u);
  sum.add_product(a.v, c.u);
  sum.add_product(c.v, b.u);
  return sum.sign();
}

/// A coordinate plane, seen from the side from which the polygon is counterclockwise. Coordinates
/// in it are those in space, without rounding.
class Plane {
 public:
  explicit Plane(const Vector3<double>& area) {
    const int z = std::abs(area.x) > std::abs(area.y)
                      ? (std::abs(area.x) > std::abs(area.z) ? 0 : 2)
                      : (std::abs(area.y) > std::abs(area.z) ? 1 : 2);
    u_ = (z + 1) % 3;
    v_ = (z + 2) % 3;
    if (area[z] < 0) std::swap(u_, v_);
  }
  PlanePoint operator()(const Vector3<double>& p) const { return {p[u_], p[v_]}; }

 private:
  int u_ = 0, v_ = 1;
};

double length_of(const Vector3<double>& a) { return std::sqrt(dot(a, a)); }

/// The area vectors of the triangles around the first corner, twice.
struct AreaSums {
  Vector3<double> area{0, 0, 0};
  double absolute = 0;
  double rounding = 0;  ///< what rounding of the positions makes of a polygon on a line, at most

  bool is_on_line() const { return !(absolute > rounding); }
  bool is_balanced() const { return !(length_of(area) > rounding); }
};

AreaSums area_sums(std::span<const Vector3<double>> positions, Triangles triangles) {
  AreaSums sums;
  const Vector3<double>& first = positions[triangles[0][0]];
  double farthest = 0, largest = 0;
  for (const auto& [a, b, c] : triangles) {
    const Vector3<double> area = cross(positions[b] - first, positions[c] - first);
    sums.area = sums.area + area;
    sums.absolute += length_of(area);
    for (const VertexId vertex : {a, b, c}) {
      const Vector3<double>& p = positions[vertex];
      largest = std::max({largest, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
      farthest = std::max(farthest, length_of(p - first));
    }
  }
  constexpr double kRoundings = 8;
  sums.rounding = kRoundings * static_cast<double>(triangles.size()) *
                  std::numeric_limits<double>::epsilon() * largest * farthest;
  return sums;
}

bool follows_itself(Triangles triangles) {
  const auto& last = triangles.back();
  if (triangles[0][0] == triangles[0][1] || last[2] == last[0]) return true;
  return std::ranges::any_of(triangles, [](const auto& each) { return each[1] == each[2]; });
}

class EarCutter {
 public:
  EarCutter(std::vector<PlanePoint> points, std::span<const VertexId> corners)
      : points_(std::move(points)), corners_(corners), ear_(points_.size()) {
    for (std::size_t at = 0; at < points_.size(); ++at) {
      next_.push_back((at + 1) % points_.size());
      before_.push_back((at + points_.size() - 1) % points_.size());
    }
  }

  /// Two sides that cross, or nothing.
  std::string crossing() const {
    for (std::size_t one = 0; one < points_.size(); ++one)
      for (std::size_t two = one + 2; two < points_.size(); ++two)
        if (cross_each_other(one, two)) return fmt::format("whose sides {} and {} cross", one, two);
    return {};
  }

  bool cut(std::span<std::array<VertexId, 3>> triangles) {
    find_ears();
    std::size_t at = 0, passed = 0, left = points_.size();
    bool found_anew = false;
    for (auto& triangle : triangles) {
      while (ear_[at] == 0) {
        at = next_[at];
        if (++passed <= left) continue;
        // A polygon that touches itself may have ears that it had not before. Of one with two
        // corners at one place, as at the poles of a sphere, a triangle without area is left.
        if (found_anew) {
          if (!find_flat_corner(at)) return false;
          break;
        }
        find_ears();
        found_anew = true;
        passed = 0;
      }
      found_anew = false;
      passed = 0;
      const std::size_t before = before_[at], after = next_[at];
      triangle = {corners_[before], corners_[at], corners_[after]};
      next_[before] = after;
      before_[after] = before;
      first_ = after;
      --left;
      ear_[before] = is_ear(before) ? 1 : 0;
      ear_[after] = is_ear(after) ? 1 : 0;
      at = next_[after];  // the next ear elsewhere: fewer needles
    }
    return true;
  }

 private:
  bool cross_each_other(std::size_t one, std::size_t two) const {
    const PlanePoint a = points_[one], b = points_[next_[one]], c = points_[two],
                     d = points_[next_[two]];
    if (std::max(a.u, b.u) < std::min(c.u, d.u) || std::max(c.u, d.u) < std::min(a.u, b.u) ||
        std::max(a.v, b.v) < std::min(c.v, d.v) || std::max(c.v, d.v) < std::min(a.v, b.v))
      return false;
    return turn(a, b, c) * turn(a, b, d) < 0 && turn(c, d, a) * turn(c, d, b) < 0;
  }

  void find_ears() {
    std::size_t at = first_;
    do {
      ear_[at] = is_ear(at) ? 1 : 0;
      at = next_[at];
    } while (at != first_);
  }

  bool find_flat_corner(std::size_t& at) const {
    at = first_;
    do {
      if (turn(points_[before_[at]], points_[at], points_[next_[at]]) == 0) return true;
      at = next_[at];
    } while (at != first_);
    return false;
  }

  /// Whether the triangle has the side of the polygon, and no other corner lies in it or on it.
  bool is_ear(std::size_t at) const {
    const std::size_t before = before_[at], after = next_[at];
    const PlanePoint a = points_[before], b = points_[at], c = points_[after];
    if (turn(a, b, c) <= 0) return false;
    for (std::size_t other = next_[after]; other != before; other = next_[other]) {
      const PlanePoint p = points_[other];
      if (p == a || p == b || p == c) continue;
      if (turn(a, b, p) >= 0 && turn(b, c, p) >= 0 && turn(c, a, p) >= 0) return false;
    }
    return true;
  }

  std::vector<PlanePoint> points_;
  std::span<const VertexId> corners_;
  std::vector<std::uint8_t> ear_;
  std::vector<std::size_t> next_, before_;
  std::size_t first_ = 0;  ///< a corner that is left
};

}  // namespace

bool is_divided_around_first(std::span<const Vector3<double>> positions, Triangles triangles) {
  const AreaSums sums = area_sums(positions, triangles);
  if (!std::isfinite(sums.absolute) || sums.is_on_line() || follows_itself(triangles)) return true;
  if (sums.is_balanced()) return false;
  const Plane plane(sums.area);
  const PlanePoint first = plane(positions[triangles[0][0]]),
                   second = plane(positions[triangles[0][1]]);
  bool beyond_half = false;
  for (const auto& triangle : triangles) {
    const PlanePoint b = plane(positions[triangle[1]]), c = plane(positions[triangle[2]]);
    if (turn(first, b, c) <= 0) return false;
    const int side = turn(first, second, c);
    if (side > 0 && beyond_half) return false;  // more than once around
    beyond_half = beyond_half || side < 0;
  }
  return true;
}

std::string cut_ears(std::span<const Vector3<double>> positions, std::span<const VertexId> corners,
                     std::span<std::array<VertexId, 3>> triangles) {
  if (corners.size() > kMostEarCorners)
    return fmt::format("that are not convex, and {} are the most for such a polygon",
                       kMostEarCorners);
  const AreaSums sums = area_sums(positions, triangles);
  if (sums.is_balanced()) return "whose sides cross, so that the area is 0";
  const Plane plane(sums.area);
  std::vector<PlanePoint> points;
  for (const VertexId vertex : corners) points.push_back(plane(positions[vertex]));
  EarCutter cutter(std::move(points), corners);
  if (std::string crossing = cutter.crossing(); !crossing.empty()) return crossing;
  return cutter.cut(triangles) ? "" : "that touch or overlap each other";
}

PLAIT_END_NAMESPACE
