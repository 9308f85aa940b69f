// Linear subdivision on the diamond of an edge: an odd vertex is the middle of its edge.
// Pinned by tests/kernels/schemes_test.cpp.
#pragma once

#include <cstdint>

#include "diamond/diamond.h"
#include "plait/vector3.h"

namespace plait::midpoint {

template <class Real>
constexpr Real odd(Real a, Real b) {
  return Real(0.5) * (a + b);
}

/// The slot at level diamond.level() + 1.
template <class Real>
void odd_slot(const Diamond<Vector3<Real>>& diamond, bool border, Vector3<Real>* slot) noexcept {
  const std::int64_t n = diamond.size();
  for (std::int64_t row = 0; row < n; ++row) {
    const std::int64_t columns = border ? n - row : n;
    const Real* lower = &diamond.at(row, 1)->x;
    const Real* upper = &diamond.at(row + 1, 0)->x;
    Real* to = &slot->x;
    for (std::int64_t k = 0; k < 3 * columns; ++k) to[k] = odd(lower[k], upper[k]);
    slot += columns;
  }
}

}  // namespace plait::midpoint
