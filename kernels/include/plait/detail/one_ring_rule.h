// plait/detail/one_ring_rule.h: the functions of a one-ring rule (a subdivision rule whose new
// vertices depend on one-rings), and how plait calls them. docs/schemes.md has an example of ten
// lines.
//
// A rule is a struct with function templates. Their parameter V is a type Numbers, which contains
// one number or a register of numbers. So a rule has no branch on values, and uses only the
// operators of Numbers.
//
//   V odd(V a, V b, V c, V d)      a new vertex on the edge between `a` and `b`; `c` and `d` lie
//                                  opposite. The bits stay the same when `a` and `b`, or `c` and
//                                  `d`, change places: each face calls it in an order of its own.
//   V odd_border(V a, V b)         the same where the edge lies on a border
//
// If the rule moves even vertices, it also has these three functions, which read the new
// neighbours:
//
//   V even(V v, V ring)            a vertex with six new neighbours, whose sum is `ring`
//   V even_border(V v, V p, V q)   a vertex on a border; `p` and `q` are new and lie on the border
//   double even_weight(int n)      w: a base vertex with n new neighbours goes to (1 - n w) v + w
//                                  times their sum, evaluated in double
//
// If odd() reads only `a` and `b`, and equals odd_border(), the rule may have the member `static
// constexpr bool kReadsEndsOnly = true;`. Then the executors do not fetch `c` and `d`.
//
// If the rule has limit positions, it also has limit(v, ring), limit_border(v, p, q) and
// limit_weight(n). They have the same form as the functions for even vertices, and read the
// neighbours at the finest level.
#pragma once

#include <concepts>

#include "plait/detail/namespace.h"
#include "plait/detail/numbers.h"

PLAIT_BEGIN_NAMESPACE

template <class Rule>
concept OneRingRule = requires(const Rule& rule, Number<float> v) {
  { rule.odd(v, v, v, v) } -> std::same_as<Number<float>>;
  { rule.odd_border(v, v) } -> std::same_as<Number<float>>;
};

template <class Rule>
constexpr bool kMovesEven = requires(const Rule& rule, Number<float> v) {
  { rule.even(v, v) } -> std::same_as<Number<float>>;
  { rule.even_border(v, v, v) } -> std::same_as<Number<float>>;
  { rule.even_weight(6) } -> std::same_as<double>;
};
template <class Rule>
constexpr bool kReadsEndsOnly = requires {
  requires Rule::kReadsEndsOnly;
};
template <class Rule>
constexpr bool kHasLimits = requires(const Rule& rule, Number<float> v) {
  { rule.limit(v, v) } -> std::same_as<Number<float>>;
  { rule.limit_border(v, v, v) } -> std::same_as<Number<float>>;
  { rule.limit_weight(6) } -> std::same_as<double>;
};

/// Whether a rule has all functions of a group or none of them. A group in part is a mistake.
template <class Rule>
constexpr bool kIsWhole =
    (kMovesEven<Rule> || !(
                             requires(const Rule& r, Number<float> v) { r.even(v, v); } ||
                             requires(const Rule& r, Number<float> v) { r.even_border(v, v, v); } ||
                             requires(const Rule& r) { r.even_weight(6); })) &&
    (kHasLimits<Rule> ||
     !(
         requires(const Rule& r, Number<float> v) { r.limit(v, v); } ||
         requires(const Rule& r, Number<float> v) { r.limit_border(v, v, v); } ||
         requires(const Rule& r) { r.limit_weight(6); }));

/// The sum of a regular one-ring, from the sums of its opposite pairs. The pair sums are added in
/// order of size, so the bits do not depend on the first vertex and the direction of the ring.
template <class V>
[[gnu::always_inline]] inline V ring_sum(const V& pair0, const V& pair1, const V& pair2) {
  const V low = smaller(pair0, pair1), high = larger(pair0, pair1);
  const V middle = smaller(high, pair2);
  return (smaller(low, middle) + larger(low, middle)) + larger(high, pair2);
}
/// The same for points p0 .. p5 in order around a vertex.
template <class Real>
[[gnu::always_inline]] inline Vector3<Real> ring_sum(
    const Vector3<Real>& p0, const Vector3<Real>& p1, const Vector3<Real>& p2,
    const Vector3<Real>& p3, const Vector3<Real>& p4, const Vector3<Real>& p5) {
  return by_axis([](auto a, auto b, auto c) { return ring_sum(a, b, c); }, p0 + p3, p1 + p4,
                 p2 + p5);
}

/// The ring of a base vertex of any valence, in double. (In float, a sum over a hundred thousand
/// neighbours would have no correct digits.)
struct BaseRing {
  int valence = 0;
  Vector3<double> sum{}, first{}, last{};
};

/// (1 - n w) v + w ring, for a base vertex of valence n, or for registers of such vertices.
template <class V>
[[gnu::always_inline]] inline V weighted(int valence, double weight, const V& v, const V& ring) {
  return (1 - valence * weight) * v + weight * ring;
}

PLAIT_END_NAMESPACE
