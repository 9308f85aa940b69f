// plait/detail/rule_slots.h: applies a rule to the slot of an edge, and reads the edge's grid. The
// sweep executor uses these functions. Pinned by tests/kernels/slot_rows_test.cpp.
#pragma once

#include <cstdint>
#include <cstring>

#include "plait/detail/edge_grid.h"
#include "plait/detail/namespace.h"
#include "plait/detail/one_ring_rule.h"
#include "plait/extend/edge_index.h"

PLAIT_BEGIN_NAMESPACE
namespace rule_slots {

/// Loads the three numbers of a record at once. In float32 they take one register, and its fourth
/// number is not used. In float64 they are three separate numbers.
template <class Real>
struct PointNumbers;

template <>
struct PointNumbers<float> {
  using V = Numbers<float, 4>;
  /// REQUIRES: the 4 bytes after the record are readable, as they are in an EdgeGrid.
  static V load(const Vector3<float>* record) { return V::load(&record->x); }
  /// Reads the record and no byte after it.
  static V load_exactly(const Vector3<float>* record) {
    return {typename V::Vector{record->x, record->y, record->z, 0}};
  }
  static void store(const V& point, Vector3<float>* to) {
    std::memcpy(to, &point.v, sizeof(Vector3<float>));
  }
};

template <>
struct PointNumbers<double> {
  struct V {
    Number<double> x, y, z;

    friend V operator+(const V& a, const V& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
    friend V operator-(const V& a, const V& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
    friend V operator*(const V& a, const V& b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }
    friend V operator*(double s, const V& a) { return {s * a.x, s * a.y, s * a.z}; }
    friend V operator/(const V& a, double s) { return {a.x / s, a.y / s, a.z / s}; }
    friend V smaller(const V& a, const V& b) {
      return {smaller(a.x, b.x), smaller(a.y, b.y), smaller(a.z, b.z)};
    }
    friend V larger(const V& a, const V& b) {
      return {larger(a.x, b.x), larger(a.y, b.y), larger(a.z, b.z)};
    }
  };
  static V load(const Vector3<double>* record) { return {{record->x}, {record->y}, {record->z}}; }
  static V load_exactly(const Vector3<double>* record) { return load(record); }
  static void store(const V& point, Vector3<double>* to) {
    *to = {point.x.v, point.y.v, point.z.v};
  }
};

/// Computes the slot at level grid.level() + 1 from the coarser mesh in `grid`. An odd vertex is in
/// a cell of the grid. A and B are on the cell's diagonal along the edge, C and D on the other
/// diagonal.
template <class V, class Rule, class Real>
void odd_slot(const Rule& rule, const EdgeGrid<Vector3<Real>>& grid, const SlotRows& rows,
              Vector3<Real>* slot) {
  static_assert(sizeof(Vector3<Real>) == 3 * sizeof(Real));
  const std::int64_t n = grid.size();
  for (std::int64_t row = 0; row < n; ++row) {
    const std::int64_t columns = rows.inside(n, row);
    const Real* lower = &grid.at(row, 0)->x;
    const Real* upper = &grid.at(row + 1, 0)->x;
    Real* to = &slot->x;
    std::int64_t k = 0;
    for (; k + V::kCount <= 3 * columns; k += V::kCount)
      rule.odd(V::load(lower + k + 3), V::load(upper + k), V::load(lower + k),
               V::load(upper + k + 3))
          .store(to + k);
    using One = Number<Real>;
    for (; k < 3 * columns; ++k)
      rule.odd(One{lower[k + 3]}, One{upper[k]}, One{lower[k]}, One{upper[k + 3]}).store(to + k);
    slot += columns;
    // The last vertex in a row of a border edge's slot is on the border itself.
    if (rows.border)
      *slot++ = by_axis([&](auto a, auto b) { return rule.odd_border(a, b); },
                        *grid.at(row, n - row), *grid.at(row + 1, n - 1 - row));
  }
}

/// The neighbours of a grid vertex, in the order that ring_sum() expects.
template <class Real>
auto ring_sum_at(const Vector3<Real>* v, std::int64_t stride) {
  using At = PointNumbers<Real>;
  return ring_sum(At::load(v + stride) + At::load(v - stride), At::load(v + 1) + At::load(v - 1),
                  At::load(v + 1 - stride) + At::load(v + stride - 1));
}

/// Moves the vertices of the slot at `level`. `grid` has the new odd vertices. REQUIRES: level <
/// grid.level().
template <class Rule, class Real>
void even_slot(const Rule& rule, const EdgeGrid<Vector3<Real>>& grid, int level,
               const SlotRows& rows, Vector3<Real>* slot) {
  using At = PointNumbers<Real>;
  const std::int64_t stride = grid.stride();
  for_each_slot_row(
      grid, level,
      [&](std::int64_t row, const Vector3<Real>* v, std::int64_t step, std::int64_t n) {
        const std::int64_t inside = rows.inside(n, row);
        for (std::int64_t column = 0; column < inside; ++column, v += step, ++slot)
          At::store(rule.even(At::load_exactly(slot), ring_sum_at(v, stride)), slot);
        if (!rows.border) return;
        *slot = by_axis([&](auto a, auto p, auto q) { return rule.even_border(a, p, q); }, *slot,
                        v[1 - stride], v[stride - 1]);
        ++slot;
      });
}

/// Computes the limit positions of the slot at `level`. `grid` has the finest level.
template <class Rule, class Real>
void limit_slot(const Rule& rule, const EdgeGrid<Vector3<Real>>& grid, int level,
                const SlotRows& rows, Vector3<Real>* slot) {
  using At = PointNumbers<Real>;
  const std::int64_t stride = grid.stride();
  for_each_slot_row(
      grid, level,
      [&](std::int64_t row, const Vector3<Real>* v, std::int64_t step, std::int64_t n) {
        const std::int64_t inside = rows.inside(n, row);
        for (std::int64_t column = 0; column < inside; ++column, v += step, ++slot)
          At::store(rule.limit(At::load(v), ring_sum_at(v, stride)), slot);
        if (rows.border)
          *slot++ = by_axis([&](auto a, auto p, auto q) { return rule.limit_border(a, p, q); }, *v,
                            v[1 - stride], v[stride - 1]);
      });
}

}  // namespace rule_slots
PLAIT_END_NAMESPACE
