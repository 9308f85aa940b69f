// The predictions and residuals of the filter hierarchy, written down vertex by vertex as
// docs/filters/hierarchy.md says.
#pragma once

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <string>
#include <utility>

#include "backends/compressed/filters/predicted_levels.h"
#include "plait/extend/edge_index.h"
#include "plait/extend/topology.h"

namespace plait::test {

/// Predicts single vertices by face indices and unfolding, as docs/filters/hierarchy.md says.
template <class Number>
class Oracle {
 public:
  /// `knows(level, edge)` says which slots of coarser levels are known.
  Oracle(
      const PredictedLevels<Number>& levels, const std::string& rule,
      std::function<bool(int, EdgeId)> knows = [](int, EdgeId) { return true; })
      : levels_(levels), mesh_(levels.surroundings.mesh), rule_(rule), knows_(std::move(knows)) {}

  Number predict(const EdgeIndex& index, std::size_t component) const {
    return predict(index, component, rule_);
  }

  /// The component in which the normal of the face with the frame of the slot is longest.
  std::size_t axis_of(int level, EdgeId edge) const {
    const FaceSide own =
        levels_.is_turned(level, edge) ? mesh_.edges[edge].other : mesh_.edges[edge].own;
    const auto side = static_cast<std::size_t>(own.side());
    const auto base = [&](std::size_t turn) {
      return levels_.base_records[mesh_.faces[own.face()][(side + turn) % 3]];
    };
    const auto from_apex = normal(minus(base(2), base(0)), minus(base(1), base(0)));
    std::size_t axis = 0;
    for (std::size_t k = 1; k < 3; ++k)
      if (std::abs(from_apex[k]) > std::abs(from_apex[axis])) axis = k;
    return axis;
  }
  /// The prediction of each component if the vertex moves along the normal and is at `found`.
  std::array<Number, 3> predict_along(const EdgeIndex& index,
                                      const std::array<Number, 3>& found) const {
    std::array<Number, 3> made;
    for (std::size_t k = 0; k < 3; ++k) made[k] = predict(index, k);
    const Edge& edge = mesh_.edges[index.edge];
    const std::int64_t n = slot_side(index.level);
    if (edge.is_border() && index.row + index.column == n - 1) return made;
    const std::size_t axis = axis_of(index.level, index.edge);
    std::array<std::array<Number, 3>, 4> near;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::array<Number, 4> each = nearest(index, k);
      for (std::size_t i = 0; i < 4; ++i) near[i][k] = each[i];
    }
    const auto upright = normal(minus(near[0], near[1]), minus(near[2], near[3]));
    for (std::size_t k = 0; k < 3; ++k) {
      const Number slope = upright[k] * (1 / upright[axis]);
      if (k != axis && std::abs(slope) <= 4) made[k] += (found[axis] - made[axis]) * slope;
    }
    return made;
  }

 private:
  using Vector = std::array<Number, 3>;
  static Vector minus(const Vector& a, const Vector& b) {
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
  }
  static Vector normal(const Vector& u, const Vector& v) {
    return {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
  }

  /// The points A, B, C and D.
  std::array<Number, 4> nearest(const EdgeIndex& index, std::size_t component) const {
    std::array<Number, 4> points{};
    predict(index, component, "butterfly", &points);
    return points;
  }

  bool face_has(FaceId face, int level) const {
    return levels_.mesh.depths() == nullptr || levels_.mesh.depths()->of(face) >= level;
  }
  /// Whether the vertex is one of this face's, or lies on the edge whose slot is predicted; and its
  /// slot is known.
  bool is_known(const FaceIndex& there, EdgeId predicted) const {
    const EdgeIndex from = edge_index(mesh_, there);
    const bool on_edge =
        from.edge == predicted && from.row + from.column == slot_side(from.level) - 1;
    return (on_edge || face_has(there.face, from.level)) && knows_(from.level, from.edge);
  }
  /// The vertex, or half the sum of its coarser neighbours in the face if it is not known.
  Number known_or_middle(const FaceIndex& there, EdgeId predicted, std::size_t component) const {
    if (is_corner(there.level, there.i, there.j) || is_known(there, predicted))
      return levels_.vertex(there)[component];
    const SideIndex at = to_side(there.level, there.i, there.j);
    const auto neighbour = [&](std::int64_t step) {
      std::int64_t weight[3];
      weight[(at.side + 1) % 3] = 2 * at.row + 1 + step;
      weight[(at.side + 2) % 3] = 2 * at.column + 1 - step;
      weight[at.side] = 2 * slot_side(at.level) - 2 * (at.row + at.column) - 2;
      return known_or_middle({there.face, at.level, weight[1], weight[2]}, predicted, component);
    };
    return Number(0.5) * (neighbour(-1) + neighbour(1));
  }

  Number predict(const EdgeIndex& index, std::size_t component, const std::string& rule,
                 std::array<Number, 4>* nearest = nullptr) const {
    const FaceIndex point = face_index(mesh_, index);
    const SideIndex at = to_side(point.level, point.i, point.j);
    const auto n = slot_side(point.level);
    // Weights of the side's start and end; the third follows.
    const std::int64_t start = 2 * at.row + 1, end = 2 * at.column + 1;
    const auto value = [&](std::int64_t p, std::int64_t q, Number& to) {
      std::int64_t weight[3];
      weight[(at.side + 1) % 3] = p;
      weight[(at.side + 2) % 3] = q;
      weight[at.side] = 2 * n - p - q;
      const FaceIndex there = unfold_fully(mesh_, {point.face, point.level, weight[1], weight[2]});
      if (there.face == kNoId) return false;
      // A wing that is not known is continued.
      if (!is_corner(there.level, there.i, there.j) && !is_known(there, index.edge) &&
          (p < 0 || q < 0 || p > 2 * n || q > 2 * n))
        return false;
      to = known_or_middle(there, index.edge, component);
      return true;
    };
    Number a{}, b{}, c{}, d{};
    value(start - 1, end + 1, a);
    value(start + 1, end - 1, b);
    if (rule == "midpoint") return Number(0.5) * (a + b);
    const bool on_edge = start + end == 2 * n;
    if (on_edge && !mesh_.across(FaceSide(point.face, at.side)).exists()) {
      Number before{}, after{};
      if (start - 3 < 0 || end - 3 < 0) return Number(0.5) * (a + b);
      value(start - 3, end + 3, before);
      value(start + 3, end - 3, after);
      return Number(0.5625) * (a + b) - Number(0.0625) * (before + after);
    }
    value(start - 1, end - 1, c);
    value(start + 1, end + 1, d);
    if (nearest != nullptr) *nearest = {a, b, c, d};
    const auto wing = [&](std::int64_t p, std::int64_t q, Number end0, Number end1, Number inside) {
      Number to{};
      return value(p, q, to) ? to : (end0 + end1) - inside;
    };
    const Number wing_ac = wing(start - 3, end + 1, a, c, b),
                 wing_db = wing(start + 3, end - 1, d, b, a);
    const Number wing_cb = wing(start + 1, end - 3, c, b, a),
                 wing_ad = wing(start - 1, end + 3, a, d, b);
    if (rule == "loop" && at.row > 0 && at.row < n - 1 && at.column > 0 && at.column < n - 1) {
      // Points of the lattice; beyond a border the continuation of the triangle inside.
      const auto known = [&](std::int64_t p, std::int64_t q) {
        Number to{};
        CHECK(value(2 * p, 2 * q, to));
        return to;
      };
      const auto far = [&](std::int64_t p, std::int64_t q) {
        Number to{};
        if (value(2 * p, 2 * q, to)) return to;
        if (p == -1) return (known(0, q) + known(0, q - 1)) - known(1, q - 1);
        if (q == -1) return (known(p, 0) + known(p - 1, 0)) - known(p - 1, 1);
        if (p == n + 1) return (known(n, q) + known(n, q + 1)) - known(n - 1, q + 1);
        CHECK(q == n + 1);
        return (known(p, n) + known(p + 1, n)) - known(p + 1, n - 1);
      };
      const std::int64_t r = at.row, k = at.column;
      const Number beyond_a = known(r - 1, k + 2), beyond_b = known(r + 2, k - 1);
      const Number c_a = far(r - 2, k + 2), c_b = far(r + 2, k - 2);
      const Number d_a = far(r - 1, k + 3), d_b = far(r + 3, k - 1);
      const Number around = ((wing_ac + wing_db) + (wing_cb + wing_ad)) + (beyond_a + beyond_b);
      return Number(0.5) * (a + b) + (((Number(0.078125) * (c + d) + Number(0.046875) * (a + b)) -
                                       Number(0.046875) * around) +
                                      Number(0.0078125) * ((c_a + c_b) + (d_a + d_b)));
    }
    return (Number(0.5) * (a + b) + Number(0.125) * (c + d)) -
           Number(0.0625) * ((wing_ac + wing_db) + (wing_cb + wing_ad));
  }

  const PredictedLevels<Number>& levels_;
  Topology mesh_;
  std::string rule_;
  std::function<bool(int, EdgeId)> knows_;
};

/// Order-preserving integers by arithmetic on signed numbers, not by changes of bits.
inline std::int64_t place_of(float number) {
  std::int32_t bits;
  std::memcpy(&bits, &number, sizeof bits);
  return bits >= 0 ? bits : -1 - std::int64_t{bits & 0x7fffffff};
}

inline std::uint32_t expected_residual(float number, float prediction) {
  const std::int64_t difference = place_of(number) - place_of(prediction);
  const auto wrapped = static_cast<std::int32_t>(static_cast<std::uint32_t>(difference));
  return wrapped >= 0 ? 2 * static_cast<std::uint32_t>(wrapped)
                      : 2 * static_cast<std::uint32_t>(-1 - std::int64_t{wrapped}) + 1;
}

}  // namespace plait::test
