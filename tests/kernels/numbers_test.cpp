// Numbers side by side: each has the bits that plain arithmetic gives it alone.
#include "plait/detail/numbers.h"

#include <array>
#include <catch2/catch.hpp>
#include <cstring>
#include <limits>

#include "plait/detail/one_ring_rule.h"

using namespace plait;

namespace {

template <class Real>
bool same_bits(Real a, Real b) {
  return (a != a && b != b) || std::memcmp(&a, &b, sizeof a) == 0;
}

/// Results that have to be rounded, zeros of both signs, numbers that overflow, and none.
template <class Real>
constexpr std::array<Real, 16> kOdd = {Real(0.1),
                                       Real(-7.3),
                                       Real(0),
                                       -Real(0),
                                       Real(1) / 3,
                                       std::numeric_limits<Real>::max(),
                                       std::numeric_limits<Real>::denorm_min(),
                                       std::numeric_limits<Real>::infinity(),
                                       Real(511.1),
                                       -Real(1) / 7,
                                       Real(1e-20),
                                       std::numeric_limits<Real>::quiet_NaN(),
                                       Real(3),
                                       -std::numeric_limits<Real>::infinity(),
                                       Real(-0.25),
                                       Real(1e19)};

/// check(a, b) for all pairs, as many at once as V has.
template <class V, class Check>
void for_all_pairs(Check check) {
  using Real = typename V::Real;
  for (std::size_t shift = 0; shift < 16; ++shift)
    for (std::size_t first = 0; first < 16; first += V::kCount) {
      std::array<Real, V::kCount> a{}, b{};
      for (std::size_t i = 0; i < V::kCount; ++i) {
        a[i] = kOdd<Real>[first + i];
        b[i] = kOdd<Real>[(first + i + shift) % 16];
      }
      check(a, b);
    }
}

template <class V, class Evaluate, class Plain>
bool agree(Evaluate evaluate, Plain plain) {
  bool same = true;
  for_all_pairs<V>([&](const auto& a, const auto& b) {
    auto found = a;
    evaluate(V::load(a.data()), V::load(b.data())).store(found.data());
    for (std::size_t i = 0; i < V::kCount; ++i) same &= same_bits(found[i], plain(a[i], b[i]));
  });
  return same;
}

}  // namespace

TEMPLATE_TEST_CASE("Numbers_EveryOperator_HasTheBitsOfPlainArithmetic", "", (Numbers<float, 1>),
                   (Numbers<float, 2>), (Numbers<float, 4>), (Numbers<double, 1>),
                   (Numbers<double, 2>)) {
  using V = TestType;
  using Real = typename V::Real;
  CHECK(agree<V>([](V a, V b) { return a + b; }, [](Real a, Real b) { return a + b; }));
  CHECK(agree<V>([](V a, V b) { return a - b; }, [](Real a, Real b) { return a - b; }));
  CHECK(agree<V>([](V a, V b) { return a * b; }, [](Real a, Real b) { return a * b; }));
  CHECK(agree<V>([](V a, V) { return 0.1 * a; }, [](Real a, Real) { return Real(0.1) * a; }));
  CHECK(agree<V>([](V a, V) { return a / 12; }, [](Real a, Real) { return a / Real(12); }));
  CHECK(agree<V>([](V a, V b) { return smaller(a, b); },
                 [](Real a, Real b) { return b < a ? b : a; }));
  CHECK(agree<V>([](V a, V b) { return larger(a, b); },
                 [](Real a, Real b) { return b < a ? a : b; }));
  if constexpr (V::kCount <= RegisterNumbers<double>::kCount)
    CHECK(agree<V>([](V a, V b) { return narrowed<Real>(0.1 * widened(a) + widened(b)); },
                   [](Real a, Real b) { return Real(0.1 * double(a) + double(b)); }));
}

TEMPLATE_TEST_CASE("RingSum_TurnedAndReversed_HasTheSameBits", "", float, double) {
  using Point = Vector3<TestType>;
  std::array<Point, 6> ring;
  for (std::size_t i = 0; i < 6; ++i) {
    const auto at = static_cast<TestType>(i);
    ring[i] = {at / 3, TestType(0.1) - at * at / 7, TestType(1) / (at + 1)};
  }
  const auto sum = [&](std::size_t start, std::size_t step) {
    const auto p = [&](std::size_t i) { return ring[(start + step * i) % 6]; };
    return ring_sum(p(0), p(1), p(2), p(3), p(4), p(5));
  };
  for (std::size_t start = 0; start < 6; ++start)
    for (const std::size_t step : {1u, 5u}) CHECK(sum(start, step) == sum(0, 1));
}
