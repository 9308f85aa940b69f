// plait/own_rule.h: makes a program's own subdivision rule available to all executors.
//
//   struct MyRule { ... };                                  // plait/detail/one_ring_rule.h
//   const plait::OneRingScheme scheme = plait::own_scheme("mine", MyRule{});
//   plait::subdivide(store, {.scheme = scheme, .levels = 5});
//
// The functions below are compiled in the program, for the program's instruction set
// (-march=x86-64-v3 makes the fused executor's registers twice as wide). They give the same bits on
// every instruction set. docs/schemes.md has figures.
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <utility>

#include "plait/detail/namespace.h"
#include "plait/detail/one_ring.h"
#include "plait/detail/one_ring_rule.h"
#include "plait/detail/rule_rows.h"
#include "plait/detail/rule_slots.h"

PLAIT_BEGIN_NAMESPACE

/// A store has room for longer names, but messages and reports print names.
inline constexpr std::size_t kMostSchemeNameBytes = 255;

/// Refuses a name that own_scheme() does not allow, and a name of a library scheme. Also refuses a
/// rule whose odd() gives other bits if `a` and `b`, or `c` and `d`, change places; it tries this
/// on a few numbers. Errors: kInvalidArgument.
void check_own_scheme(const OneRingScheme& scheme);

/// The functions to which OneRingFunctions points.
template <class Rule, class Real>
struct RuleFunctions {
  using Point = Vector3<Real>;
  using WidePoint = Vector3<double>;
  using Grid = EdgeGrid<Point>;
  using V = RegisterNumbers<Real>;
  using Wide = RegisterNumbers<double>;
  using Narrow = Numbers<Real, Wide::kCount>;

  static const Rule& of(const void* rule) { return *static_cast<const Rule*>(rule); }

  static Point odd(const void* rule, const Point& a, const Point& b, const Point& c,
                   const Point& d) {
    return by_axis([&](auto... v) { return of(rule).odd(v...); }, a, b, c, d);
  }
  static Point odd_border(const void* rule, const Point& a, const Point& b) {
    return by_axis([&](auto... v) { return of(rule).odd_border(v...); }, a, b);
  }
  static Point even(const void* rule, const Point& v, const Point& ring) {
    return by_axis([&](auto... numbers) { return of(rule).even(numbers...); }, v, ring);
  }
  static Point even_border(const void* rule, const Point& v, const Point& p, const Point& q) {
    return by_axis([&](auto... numbers) { return of(rule).even_border(numbers...); }, v, p, q);
  }
  static Point limit(const void* rule, const Point& v, const Point& ring) {
    return by_axis([&](auto... numbers) { return of(rule).limit(numbers...); }, v, ring);
  }
  static Point limit_border(const void* rule, const Point& v, const Point& p, const Point& q) {
    return by_axis([&](auto... numbers) { return of(rule).limit_border(numbers...); }, v, p, q);
  }

  static WidePoint even_base(const void* rule, const BaseRing& ring, bool border,
                             const WidePoint& v) {
    if (border) return RuleFunctions<Rule, double>::even_border(rule, v, ring.first, ring.last);
    return weighted_point(ring, of(rule).even_weight(ring.valence), v);
  }
  static WidePoint limit_base(const void* rule, const BaseRing& ring, bool border,
                              const WidePoint& v) {
    if (border) return RuleFunctions<Rule, double>::limit_border(rule, v, ring.first, ring.last);
    return weighted_point(ring, of(rule).limit_weight(ring.valence), v);
  }
  static WidePoint weighted_point(const BaseRing& ring, double weight, const WidePoint& v) {
    return by_axis(
        [&](auto centre, auto sum) { return weighted(ring.valence, weight, centre, sum); }, v,
        ring.sum);
  }

  static void odd_slot(const void* rule, const Grid& grid, const SlotRows& rows, Point* slot) {
    rule_slots::odd_slot<V>(of(rule), grid, rows, slot);
  }
  static void even_slot(const void* rule, const Grid& grid, int level, const SlotRows& rows,
                        Point* slot) {
    rule_slots::even_slot(of(rule), grid, level, rows, slot);
  }
  static void limit_slot(const void* rule, const Grid& grid, int level, const SlotRows& rows,
                         Point* slot) {
    rule_slots::limit_slot(of(rule), grid, level, rows, slot);
  }

  static void odd_row(const void* rule, const OddRow<Real>& row) {
    rule_rows::odd_row<V>(of(rule), row);
  }
  static void even_row(const void* rule, const EvenRow<Real>& row) {
    rule_rows::even_row<V>(of(rule), row);
  }
  static void limit_row(const void* rule, const SurfaceRow<Real, Real>& row) {
    rule_rows::limit_row<V>(of(rule), row);
  }
  static void ring_step(const void* rule, const RingStep<Real>& step) {
    rule_rows::ring_step<Narrow, Wide>(of(rule), step);
  }
};

/// All functions of `Rule`. Functions that it does not have are nullptr.
template <class Real, OneRingRule Rule>
OneRingFunctions<Real> functions_of() {
  static_assert(kIsWhole<Rule>,
                "a rule has all of even, even_border and even_weight or none of them; the same "
                "holds for limit, limit_border and limit_weight");
  using Of = RuleFunctions<Rule, Real>;
  OneRingFunctions<Real> made{};
  made.reads_ends_only = kReadsEndsOnly<Rule>;
  made.odd = Of::odd;
  made.odd_border = Of::odd_border;
  made.odd_slot = Of::odd_slot;
  made.odd_row = Of::odd_row;
  made.even_row = Of::even_row;
  made.ring_step = Of::ring_step;
  if constexpr (kMovesEven<Rule>) {
    made.even = Of::even;
    made.even_border = Of::even_border;
    made.even_base = Of::even_base;
    made.even_slot = Of::even_slot;
  }
  if constexpr (kHasLimits<Rule>) {
    made.limit = Of::limit;
    made.limit_border = Of::limit_border;
    made.limit_base = Of::limit_base;
    made.limit_slot = Of::limit_slot;
    made.limit_row = Of::limit_row;
  }
  return made;
}

/// Makes a scheme from a copy of `rule`. The provenance of a store records `name`: 1 to
/// kMostSchemeNameBytes letters, digits, '-' and '_'. Errors: those of check_own_scheme().
template <OneRingRule Rule>
OneRingScheme own_scheme(std::string name, const Rule& rule) {
  const auto shared = std::make_shared<const Rule>(rule);
  OneRingScheme scheme(std::move(name), OneRing<float>(shared, functions_of<float, Rule>()),
                       OneRing<double>(shared, functions_of<double, Rule>()));
  check_own_scheme(scheme);
  return scheme;
}

PLAIT_END_NAMESPACE
