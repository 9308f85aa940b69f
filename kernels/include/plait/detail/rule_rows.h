// plait/detail/rule_rows.h: applies a rule to rows of points, one register of numbers at a time.
// The fused executor uses these functions. `V` is Numbers, or a type of the library with the same
// operators for the processor's instruction set.
//
// All functions are always inlined, so that they are compiled for the instruction set of their
// caller. Pinned by tests/kernels/fused_rows_test.cpp and fused_rows_rules_test.cpp.
#pragma once

#include <cstddef>
#include <cstdint>

#include "plait/detail/namespace.h"
#include "plait/detail/one_ring_rule.h"
#include "plait/detail/rows.h"

PLAIT_BEGIN_NAMESPACE
namespace rule_rows {

template <class V, class Rule, class Real>
[[gnu::always_inline]] inline void odd_row(const Rule& rule, const OddRow<Real>& row) {
  for (std::int64_t i = 0; i < row.count; ++i) {
    const std::size_t from = static_cast<std::size_t>(i) * kPointNumbers;
    for (std::size_t k = from; k < from + kPointNumbers; k += V::kCount)
      rule.odd(V::load(row.a + k), V::load(row.b + k), V::load(row.c + k), V::load(row.d + k))
          .store(row.to + from + k);
  }
}

/// The sum of a ring, at index `at` of the rows of its points.
template <class V, class Real>
[[gnu::always_inline]] inline V ring_sum_at(const Neighbours<Real>& around, std::size_t at) {
  const auto& [pair0, pair1, pair2] = around.pairs;
  return ring_sum(V::load(pair0[0] + at) + V::load(pair0[1] + at),
                  V::load(pair1[0] + at) + V::load(pair1[1] + at),
                  V::load(pair2[0] + at) + V::load(pair2[1] + at));
}

template <class V, class Rule, class Real>
[[gnu::always_inline]] inline void even_row(const Rule& rule, const EvenRow<Real>& row) {
  for (std::int64_t i = 0; i < row.count; ++i) {
    const std::size_t from = static_cast<std::size_t>(i) * kPointNumbers;
    for (std::size_t k = from; k < from + kPointNumbers; k += V::kCount) {
      const V v = V::load(row.v + k);
      if constexpr (kMovesEven<Rule>)
        rule.even(v, ring_sum_at<V>(row.neighbours, from + k)).store(row.to + from + k);
      else
        v.store(row.to + from + k);
    }
  }
}

template <class V, class Rule, class Real>
[[gnu::always_inline]] inline void limit_row(const Rule& rule, const SurfaceRow<Real, Real>& row) {
  for (std::int64_t i = 0; i < row.count; ++i) {
    const std::size_t at = static_cast<std::size_t>(i * row.step) * kPointNumbers;
    for (std::size_t k = at; k < at + kPointNumbers; k += V::kCount)
      rule.limit(V::load(row.v + k), ring_sum_at<V>(row.neighbours, k)).store(row.to + k);
  }
}

/// Computes base vertices and their rings at the next level. `Wide` has as many numbers as `V`, in
/// double: even base vertices are computed in double.
template <class V, class Wide, class Rule, class Real>
[[gnu::always_inline]] inline void ring_step(const Rule& rule, const RingStep<Real>& step) {
  static_assert(V::kCount == Wide::kCount);
  const auto n = static_cast<std::size_t>(step.valence);
  double weight = 0;
  if constexpr (kMovesEven<Rule>) weight = step.border ? 0 : rule.even_weight(step.valence);
  for (std::size_t k = 0; k < kPointNumbers; k += V::kCount) {
    const Real* const ring = step.from + kPointNumbers + k;
    Real* const to = step.to + k;
    const V centre = V::load(step.from + k);
    V before = V::load(ring + (n - 1) * kPointNumbers), here = V::load(ring);
    V first = here, made = here;
    Wide sum = Wide::zero();
    for (std::size_t i = 0; i < n; ++i) {
      const V after = V::load(ring + (i + 1 == n ? 0 : i + 1) * kPointNumbers);
      if (step.border && (i == 0 || i + 1 == n))
        made = rule.odd_border(centre, here);
      else
        made = rule.odd(centre, here, before, after);
      made.store(to + (1 + i) * kPointNumbers);
      if (i == 0) first = made;
      sum = sum + widened(made);
      before = here;
      here = after;
    }
    if constexpr (!kMovesEven<Rule>)
      centre.store(to);
    else if (step.border)
      narrowed<Real>(rule.even_border(widened(centre), widened(first), widened(made))).store(to);
    else
      narrowed<Real>(weighted(step.valence, weight, widened(centre), sum)).store(to);
  }
}

}  // namespace rule_rows
PLAIT_END_NAMESPACE
