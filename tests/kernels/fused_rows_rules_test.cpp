// Rows of a group of patches on every instruction set of this machine against the rules as their
// papers have them, in long double and without a line of the library. What the bits are is the
// affair of fused_rows_test.cpp; this is whether they are those of the right formula.
#include <cmath>
#include <numbers>
#include <vector>

#include "kernels/row_points.h"
#include "rows/dispatched_rows.h"
#include "schemes/library_rule.h"
#include "schemes/loop.h"
#include "schemes/midpoint.h"

using namespace plait;
using namespace plait::test;

namespace {

using LongNumber = long double;
using Vector = std::array<LongNumber, 3>;

constexpr LongNumber kPi = std::numbers::pi_v<LongNumber>;

/// C. Loop, 1987: weight of one old neighbour of an interior vertex.
LongNumber loop_weight(int valence) {
  const LongNumber root = 3.0L / 8 + std::cos(2 * kPi / valence) / 4;
  return (5.0L / 8 - root * root) / valence;
}

/// Points of ordinary size, all with the same share of zeros of both signs.
template <class Real, class Check>
void for_ordinary_points(std::size_t count, Check check) {
  for (unsigned seed = 1; seed <= 6; ++seed) {
    Points<Real> points(count);
    fill(points, count, seed, Real(1), false);
    INFO("seed " << seed);
    check(points);
  }
}

/// A few roundings of numbers below 2.
template <class Real>
constexpr LongNumber tolerance() {
  return 8 * std::numeric_limits<Real>::epsilon();
}

/// [row][point], each of kPointNumbers numbers.
template <class Real>
struct Rows {
  Points<Real>& points;
  std::size_t width;
  Real* operator()(std::size_t row) const { return points.at(row * width); }
  LongNumber number(std::size_t row, std::size_t point, std::size_t k) const {
    return (*this)(row)[point * kPointNumbers + k];
  }
};

template <class Real>
void check_one_ring_rows(const OneRing<Real>& rules, bool loop) {
  // Every second point of a fine row is made, hence rows of twice as many.
  for_ordinary_points<Real>(8 * 2 * kCount, [&](Points<Real>& points) {
    const Rows<Real> row{points, 2 * kCount};
    LongNumber worst_odd = 0, worst_even = 0;
    rules.odd_row({row(0), row(1), row(2), row(3), row(7), kCount});
    for (std::size_t i = 0; i < kCount; ++i)
      for (std::size_t k = 0; k < kPointNumbers; ++k) {
        const auto [a, b, c, d] = std::array{row.number(0, i, k), row.number(1, i, k),
                                             row.number(2, i, k), row.number(3, i, k)};
        const LongNumber expected = loop ? (3 * (a + b) + c + d) / 8 : (a + b) / 2;
        worst_odd = std::max(worst_odd, std::abs(row.number(7, 2 * i, k) - expected));
      }
    CHECK(worst_odd < tolerance<Real>());

    rules.even_row(
        {row(0), {{{row(1), row(2)}, {row(3), row(4)}, {row(5), row(6)}}}, row(7), kCount});
    const LongNumber weight = 8.0L / 5 * loop_weight(6);  // of a new neighbour
    for (std::size_t i = 0; i < kCount; ++i)
      for (std::size_t k = 0; k < kPointNumbers; ++k) {
        LongNumber sum = 0;
        for (std::size_t neighbour = 1; neighbour <= 6; ++neighbour)
          sum += row.number(neighbour, 2 * i, k);
        const LongNumber v = row.number(0, i, k),
                         expected = loop ? (1 - 6 * weight) * v + weight * sum : v;
        worst_even = std::max(worst_even, std::abs(row.number(7, 2 * i, k) - expected));
      }
    CHECK(worst_even < tolerance<Real>());

    if (!loop) return;
    const Vector3<Real> v = points.get(0, 0), a = points.get(1, 0), b = points.get(2, 0),
                        found = rules.even_border(v, a, b);
    for (int axis = 0; axis < 3; ++axis) {
      const LongNumber expected = LongNumber(v[axis]) / 2 + (LongNumber(a[axis]) + b[axis]) / 4;
      CHECK(std::abs(found[axis] - expected) < tolerance<Real>());
    }
  });
}

/// The centre by the rule of the old neighbours: rows have it from the new ones.
template <class Real>
void check_one_rings(const OneRing<Real>& rules, bool loop) {
  for (const int valence : {2, 3, 4, 5, 6, 7, 12, 40})
    for (const bool border : {false, true}) {
      if (valence == 2 && !border) continue;
      INFO("valence " << valence << (border ? ", border" : ""));
      const auto n = static_cast<std::size_t>(valence);
      for_ordinary_points<Real>(2 * (n + 1), [&](Points<Real>& points) {
        const Rows<Real> ring{points, n + 1};
        rules.ring_step({ring(0), ring(1), valence, border});
        LongNumber worst = 0;
        for (std::size_t k = 0; k < kPointNumbers; ++k) {
          const LongNumber v = ring.number(0, 0, k);
          LongNumber sum = 0;
          for (std::size_t i = 1; i <= n; ++i) {
            const LongNumber p = ring.number(0, i, k);
            sum += p;
            const bool plain = !loop || (border && (i == 1 || i == n));
            const LongNumber before = ring.number(0, i == 1 ? n : i - 1, k),
                             after = ring.number(0, i == n ? 1 : i + 1, k),
                             expected = plain ? (v + p) / 2 : (3 * (v + p) + before + after) / 8;
            worst = std::max(worst, std::abs(ring.number(1, i, k) - expected));
          }
          LongNumber centre = v;
          if (loop && border)
            centre = 3 * v / 4 + (ring.number(0, 1, k) + ring.number(0, n, k)) / 8;
          else if (loop)
            centre = (1 - valence * loop_weight(valence)) * v + loop_weight(valence) * sum;
          worst = std::max(worst, std::abs(ring.number(1, 0, k) - centre));
        }
        CHECK(worst < tolerance<Real>());
      });
    }
}

/// Limit positions and, from tangents summed with cosines and sines, normals.
template <class Real>
void check_rule_surface(const OneRing<Real>& rules) {
  for_ordinary_points<Real>(8 * kCount, [&](Points<Real>& points) {
    const Rows<Real> row{points, kCount};
    const Neighbours<Real> around{
        {{row(1), row(4)}, {row(2), row(5)}, {row(3), row(6)}}};  // row 1 + i: neighbour i
    Points<float> normals(kCount);
    normal_row<Real>()({row(0), around, normals.first, 1, kCount});
    rules.limit_row({row(0), around, row(7), 1, kCount});
    LongNumber worst_limit = 0, worst_normal = 0;
    int compared = 0;
    for (std::size_t i = 0; i < kCount; ++i)
      for (std::size_t lane = 0; lane < kPatchLanes; ++lane) {
        Vector first{}, second{};
        for (std::size_t axis = 0; axis < 3; ++axis) {
          const std::size_t k = axis * kPatchLanes + lane;
          LongNumber sum = 0;
          for (int neighbour = 0; neighbour < 6; ++neighbour) {
            const LongNumber p = row.number(static_cast<std::size_t>(1 + neighbour), i, k);
            sum += p;
            first[axis] += std::cos(2 * kPi * neighbour / 6) * p;
            second[axis] += std::sin(2 * kPi * neighbour / 6) * p;
          }
          // Weight 1 / (n + 3 / (8 b)) of each neighbour.
          const LongNumber weight = 1 / (6 + 3 / (8 * loop_weight(6))),
                           expected = (1 - 6 * weight) * row.number(0, i, k) + weight * sum;
          worst_limit = std::max(worst_limit, std::abs(row.number(7, i, k) - expected));
        }
        const Vector normal{first[1] * second[2] - first[2] * second[1],
                            first[2] * second[0] - first[0] * second[2],
                            first[0] * second[1] - first[1] * second[0]};
        const LongNumber length =
            std::sqrt(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]);
        if (length < 0.5L) continue;  // nearly parallel tangents
        ++compared;
        for (std::size_t axis = 0; axis < 3; ++axis)
          worst_normal = std::max(
              worst_normal,
              std::abs(normals.get(i, lane)[static_cast<int>(axis)] - normal[axis] / length));
      }
    CHECK(worst_limit < tolerance<Real>());
    CHECK(compared > 30);
    CHECK(worst_normal < 1e-5L);
  });
}

}  // namespace

TEMPLATE_TEST_CASE("FusedRows_LoopOnEveryTarget_FollowTheRulesOfThePapers", "", float, double) {
  on_every_target([] {
    check_one_ring_rows(library_rule<LoopRule, TestType>(), true);
    check_one_rings(library_rule<LoopRule, TestType>(), true);
    check_rule_surface(library_rule<LoopRule, TestType>());
  });
}

TEMPLATE_TEST_CASE("FusedRows_MidpointOnEveryTarget_HalveEdges", "", float, double) {
  on_every_target([] {
    check_one_ring_rows(library_rule<MidpointRule, TestType>(), false);
    check_one_rings(library_rule<MidpointRule, TestType>(), false);
  });
}
