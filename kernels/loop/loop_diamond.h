// Loop's rules on the diamond of an edge: what the sweep executor evaluates.
#pragma once

#include <cstdint>
#include <span>

#include "diamond/diamond.h"
#include "diamond/lanes.h"
#include "loop/loop_expressions.h"
#include "plait/edge_index.h"
#include "plait/vector3.h"

namespace plait::loop {

/// The slot at level diamond.level() + 1 from the coarser mesh in `diamond`. An odd vertex sits in
/// a cell of the grid: A and B on the cell's diagonal along the edge, C and D on the other.
template <class Real>
void odd_slot(const Diamond<Vector3<Real>>& diamond, bool border, Vector3<Real>* slot) noexcept {
  static_assert(sizeof(Vector3<Real>) == 3 * sizeof(Real));
  const std::int64_t n = diamond.size();
  for (std::int64_t row = 0; row < n; ++row) {
    const std::int64_t columns = border ? n - 1 - row : n;
    const Real* lower = &diamond.at(row, 0)->x;
    const Real* upper = &diamond.at(row + 1, 0)->x;
    Real* to = &slot->x;
    for (std::int64_t k = 0; k < 3 * columns; ++k)
      to[k] = odd(lower[k + 3], upper[k], lower[k], upper[k + 3]);
    slot += columns;
    if (border) {
      // The last one of a border slot's row lies on the border itself.
      const Vector3<Real>& a = *diamond.at(row, n - row);
      const Vector3<Real>& b = *diamond.at(row + 1, n - 1 - row);
      *slot++ = Real(0.5) * (a + b);
    }
  }
}

/// even() and limit() of three numbers at once; see diamond/lanes.h.
inline Lanes even_at_once(const Lanes& v, const Lanes& pair0, const Lanes& pair1,
                          const Lanes& pair2) {
  return 0.4f * v + 0.1f * ring_sum(pair0, pair1, pair2);
}
inline Vector3<double> even_at_once(const Vector3<double>& v, const Vector3<double>& pair0,
                                    const Vector3<double>& pair1, const Vector3<double>& pair2) {
  return by_axis<double>(even<double>, v, pair0, pair1, pair2);
}
inline Lanes limit_at_once(const Lanes& v, const Lanes& pair0, const Lanes& pair1,
                           const Lanes& pair2) {
  return 0.5f * v + ring_sum(pair0, pair1, pair2) / 12.0f;
}
inline Vector3<double> limit_at_once(const Vector3<double>& v, const Vector3<double>& pair0,
                                     const Vector3<double>& pair1, const Vector3<double>& pair2) {
  return by_axis<double>(limit<double>, v, pair0, pair1, pair2);
}

/// Moves the slot at `level` < diamond.level(), which holds the new odd vertices.
template <class Real>
void even_slot(const Diamond<Vector3<Real>>& diamond, int level, bool border,
               Vector3<Real>* slot) noexcept {
  const std::int64_t stride = diamond.stride();
  for_each_slot_row(
      diamond, level,
      [&](std::int64_t row, const Vector3<Real>* v, std::int64_t step, std::int64_t n) {
        const std::int64_t inside = border ? n - 1 - row : n;
        for (std::int64_t column = 0; column < inside; ++column, v += step, ++slot)
          store(
              even_at_once(load_exactly(slot), load(v + stride) + load(v - stride),
                           load(v + 1) + load(v - 1), load(v + 1 - stride) + load(v + stride - 1)),
              slot);
        if (!border) return;
        *slot = by_axis<Real>(even_border<Real>, *slot, v[1 - stride], v[stride - 1]);
        ++slot;
      });
}

/// Limit positions of the slot at `level`; `diamond` holds the whole finest mesh.
template <class Real>
void limit_slot(const Diamond<Vector3<Real>>& diamond, int level, bool border,
                Vector3<Real>* slot) noexcept {
  const std::int64_t stride = diamond.stride();
  for_each_slot_row(
      diamond, level,
      [&](std::int64_t row, const Vector3<Real>* v, std::int64_t step, std::int64_t n) {
        const std::int64_t inside = border ? n - 1 - row : n;
        for (std::int64_t column = 0; column < inside; ++column, v += step, ++slot)
          store(
              limit_at_once(load(v), load(v + stride) + load(v - stride), load(v + 1) + load(v - 1),
                            load(v + 1 - stride) + load(v + stride - 1)),
              slot);
        if (!border) return;
        *slot++ = by_axis<Real>(limit_border<Real>, *v, v[1 - stride], v[stride - 1]);
      });
}

}  // namespace plait::loop
