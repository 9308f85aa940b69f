// Rows of a group of patches on every instruction set of this machine: the bits of the scalar
// rules, number by number.
#include <memory>
#include <vector>

#include "kernels/row_points.h"
#include "normals/normal_rules.h"
#include "rows/dispatched_rows.h"
#include "schemes/library_rule.h"
#include "schemes/loop.h"
#include "schemes/midpoint.h"

using namespace plait;
using namespace plait::test;

namespace {

// The rules once more, in plain numbers: what the library evaluates in registers is compared with
// these.
namespace plain {

template <class Real>
Real odd(bool loop_rule, Real a, Real b, Real c, Real d) {
  return loop_rule ? Real(0.375) * (a + b) + Real(0.125) * (c + d) : Real(0.5) * (a + b);
}
template <class Real>
Real ring_sum(Real pair0, Real pair1, Real pair2) {
  const Real low = pair1 < pair0 ? pair1 : pair0, high = pair1 < pair0 ? pair0 : pair1;
  const Real middle = pair2 < high ? pair2 : high, largest = pair2 < high ? high : pair2;
  return ((middle < low ? middle : low) + (middle < low ? low : middle)) + largest;
}
template <class Real>
Real even(Real v, Real pair0, Real pair1, Real pair2) {
  return Real(0.4) * v + Real(0.1) * ring_sum(pair0, pair1, pair2);
}
template <class Real>
Real even_border(Real v, Real p, Real q) {
  return Real(0.5) * v + Real(0.25) * (p + q);
}
template <class Real>
Real limit(Real v, Real pair0, Real pair1, Real pair2) {
  return Real(0.5) * v + ring_sum(pair0, pair1, pair2) / Real(12);
}

}  // namespace plain

template <class Real>
void check_refining(const OneRing<Real>& rule, bool loop_rule) {
  constexpr std::size_t kFine = 2 * kCount;
  for_all_points<Real>(4 * kCount + 7 * kFine, [&](Points<Real>& points) {
    const auto coarse = [&](std::size_t row) { return points.at(row * kCount); };
    const auto fine = [&](std::size_t row) { return points.at(4 * kCount + row * kFine); };
    Real* const to = fine(6);
    const std::vector<Real> before(to, to + kFine * kPointNumbers);
    bool odd_same = true, even_same = true, others_untouched = true;
    rule.odd_row({coarse(0), coarse(1), coarse(2), coarse(3), to, kCount});
    for (std::size_t i = 0; i < kCount * kPointNumbers; ++i) {
      const std::size_t at = i + i / kPointNumbers * kPointNumbers;
      odd_same &= same_bits(
          to[at], plain::odd(loop_rule, coarse(0)[i], coarse(1)[i], coarse(2)[i], coarse(3)[i]));
      others_untouched &= same_bits(to[at + kPointNumbers], before[at + kPointNumbers]);
    }
    rule.even_row(
        {coarse(0), {{{fine(0), fine(1)}, {fine(2), fine(3)}, {fine(4), fine(5)}}}, to, kCount});
    for (std::size_t i = 0; i < kCount * kPointNumbers; ++i) {
      const std::size_t at = i + i / kPointNumbers * kPointNumbers;
      const Real v = coarse(0)[i];
      even_same &= same_bits(
          to[at], loop_rule ? plain::even(v, fine(0)[at] + fine(1)[at], fine(2)[at] + fine(3)[at],
                                          fine(4)[at] + fine(5)[at])
                            : v);
      others_untouched &= same_bits(to[at + kPointNumbers], before[at + kPointNumbers]);
    }
    CHECK(odd_same);
    CHECK(even_same);
    CHECK(others_untouched);
    if (!loop_rule) return;
    for (std::size_t lane = 0; lane < kPatchLanes; ++lane) {
      const Vector3<Real> v = points.get(0, lane), a = points.get(1, lane), b = points.get(2, lane),
                          found = rule.even_border(v, a, b);
      for (int axis = 0; axis < 3; ++axis)
        CHECK(same_bits(found[axis], plain::even_border(v[axis], a[axis], b[axis])));
    }
  });
}

/// Limit positions and normals of every `step`-th point.
template <class Real>
void check_surface(const OneRing<Real>& rule, std::size_t step) {
  const std::size_t width = kCount * step;
  for_all_points<Real>(8 * width, [&](Points<Real>& points) {
    const auto row = [&](std::size_t number) { return points.at(number * width); };
    const Neighbours<Real> around{{{row(1), row(2)}, {row(3), row(4)}, {row(5), row(6)}}};
    Points<float> normals(width);
    normal_row<Real>()({row(0), around, normals.first, static_cast<std::int64_t>(step), kCount});
    rule.limit_row({row(0), around, row(7), static_cast<std::int64_t>(step), kCount});
    bool normals_same = true, limits_same = true;
    for (std::size_t i = 0; i < kCount; ++i)
      for (std::size_t lane = 0; lane < kPatchLanes; ++lane) {
        const auto point = [&](std::size_t number) {
          return points.get(number * width + i * step, lane);
        };
        const Vector3<float> normal =
            normals::regular(point(1) - point(2), point(3) - point(4), point(5) - point(6));
        for (int axis = 0; axis < 3; ++axis) {
          normals_same &= same_bits(normals.get(i * step, lane)[axis], normal[axis]);
          limits_same &= same_bits(
              point(7)[axis],
              plain::limit(point(0)[axis], point(1)[axis] + point(2)[axis],
                           point(3)[axis] + point(4)[axis], point(5)[axis] + point(6)[axis]));
        }
      }
    CHECK(normals_same);
    CHECK(limits_same);
  });
}

/// A base vertex and its ring, written down as the in-place rules say, one lane at a time.
template <class Real>
void check_rings(const OneRing<Real>& rule, bool loop_rule) {
  for (const int valence : {2, 3, 4, 5, 6, 7, 12, 40})
    for (const bool border : {false, true}) {
      if (valence == 2 && !border) continue;
      const auto n = static_cast<std::size_t>(valence);
      INFO("valence " << valence << (border ? ", border" : ""));
      for_all_points<Real>(2 * (n + 1), [&](Points<Real>& points) {
        rule.ring_step({points.at(0), points.at(n + 1), valence, border});
        bool same = true;
        for (std::size_t k = 0; k < kPointNumbers; ++k) {
          const auto old = [&](std::size_t point) { return points.at(point)[k]; };
          const auto made = [&](std::size_t point) { return points.at(n + 1 + point)[k]; };
          double sum = 0;
          for (std::size_t i = 1; i <= n; ++i) {
            const Real odd = border && (i == 1 || i == n)
                                 ? Real(0.5) * (old(0) + old(i))
                                 : plain::odd(loop_rule, old(0), old(i), old(i == 1 ? n : i - 1),
                                              old(i == n ? 1 : i + 1));
            same &= same_bits(made(i), odd);
            sum += double(odd);
          }
          Real centre = old(0);
          if (loop_rule && border) {
            centre = Real(plain::even_border(double(old(0)), double(made(1)), double(made(n))));
          } else if (loop_rule) {
            const double weight = LoopRule().even_weight(valence);
            centre = Real((1 - valence * weight) * double(old(0)) + weight * sum);
          }
          same &= same_bits(made(0), centre);
        }
        CHECK(same);
      });
    }
}

}  // namespace

TEMPLATE_TEST_CASE("FusedRows_LoopOnEveryTarget_HasTheBitsOfTheScalarRules", "", float, double) {
  on_every_target([] {
    const auto rule = library_rule<LoopRule, TestType>();
    check_refining(rule, true);
    check_rings(rule, true);
  });
}

TEMPLATE_TEST_CASE("FusedRows_MidpointOnEveryTarget_HasTheBitsOfTheScalarRules", "", float,
                   double) {
  on_every_target([] {
    const auto rule = library_rule<MidpointRule, TestType>();
    check_refining(rule, false);
    check_rings(rule, false);
  });
}

// What a program gets that has a rule of its own.
TEMPLATE_TEST_CASE("FusedRows_CompiledForTheProgram_HaveTheBitsOfTheScalarRules", "", float,
                   double) {
  const OneRing<TestType> loop(std::make_shared<LoopRule>(), functions_of<TestType, LoopRule>());
  check_refining(loop, true);
  check_rings(loop, true);
  check_surface(loop, 2);
  const OneRing<TestType> midpoint(std::make_shared<MidpointRule>(),
                                   functions_of<TestType, MidpointRule>());
  check_refining(midpoint, false);
  check_rings(midpoint, false);
}

TEMPLATE_TEST_CASE("FusedRows_SurfaceOnEveryTarget_HasTheBitsOfTheScalarRules", "", float, double) {
  on_every_target([] {
    for (const std::size_t step : {1u, 2u, 8u})
      check_surface(library_rule<LoopRule, TestType>(), step);
  });
}

TEST_CASE("FusedRows_TargetAfterTarget_AreDifferentFunctions") {
  std::vector<void (*)(const void*, const OddRow<float>&)> seen;
  on_every_target([&] {
    OneRingFunctions<float> functions{};
    choose_rows<LoopRule>(functions);
    seen.push_back(functions.odd_row);
  });
  for (std::size_t i = 0; i < seen.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) CHECK(seen[i] != seen[j]);
}
