// Rows of a group of patches on every instruction set of this machine: the bits of the scalar
// rules, number by number.
#include <vector>

#include "fused/builtin_rows.h"
#include "kernels/row_points.h"
#include "loop/loop_expressions.h"
#include "midpoint/midpoint_diamond.h"
#include "normals/normal_rules.h"

using namespace plait;
using namespace plait::test;

namespace {

template <class Real>
Real odd_of(bool loop_rule, Real a, Real b, Real c, Real d) {
  return loop_rule ? loop::odd(a, b, c, d) : midpoint::odd(a, b);
}

template <class Real>
void check_refining(const fused_rows::OneRingRows<Real>& rows, bool loop_rule) {
  constexpr std::size_t kFine = 2 * kCount;
  for_all_points<Real>(4 * kCount + 7 * kFine, [&](Points<Real>& points) {
    const auto coarse = [&](std::size_t row) { return points.at(row * kCount); };
    const auto fine = [&](std::size_t row) { return points.at(4 * kCount + row * kFine); };
    Real* const to = fine(6);
    const std::vector<Real> before(to, to + kFine * kPointNumbers);
    bool odd_same = true, even_same = true, others_untouched = true;
    rows.odd({coarse(0), coarse(1), coarse(2), coarse(3), to, kCount});
    for (std::size_t i = 0; i < kCount * kPointNumbers; ++i) {
      const std::size_t at = i + i / kPointNumbers * kPointNumbers;
      odd_same &= same_bits(
          to[at], odd_of(loop_rule, coarse(0)[i], coarse(1)[i], coarse(2)[i], coarse(3)[i]));
      others_untouched &= same_bits(to[at + kPointNumbers], before[at + kPointNumbers]);
    }
    rows.even(
        {coarse(0), {{{fine(0), fine(1)}, {fine(2), fine(3)}, {fine(4), fine(5)}}}, to, kCount});
    for (std::size_t i = 0; i < kCount * kPointNumbers; ++i) {
      const std::size_t at = i + i / kPointNumbers * kPointNumbers;
      const Real v = coarse(0)[i];
      even_same &= same_bits(
          to[at], loop_rule ? loop::even(v, fine(0)[at] + fine(1)[at], fine(2)[at] + fine(3)[at],
                                         fine(4)[at] + fine(5)[at])
                            : v);
      others_untouched &= same_bits(to[at + kPointNumbers], before[at + kPointNumbers]);
    }
    CHECK(odd_same);
    CHECK(even_same);
    CHECK(others_untouched);
    for (std::size_t lane = 0; lane < kPatchLanes; ++lane) {
      const Vector3<Real> v = points.get(0, lane), a = points.get(1, lane), b = points.get(2, lane),
                          found = rows.border(v, a, b);
      for (int axis = 0; axis < 3; ++axis)
        CHECK(same_bits(found[axis],
                        loop_rule ? loop::even_border(v[axis], a[axis], b[axis]) : v[axis]));
    }
  });
}

/// Limit positions and normals of every `step`-th point.
template <class Real>
void check_surface(const fused_rows::PatchRows<Real>& rows, std::size_t step) {
  const std::size_t width = kCount * step;
  for_all_points<Real>(8 * width, [&](Points<Real>& points) {
    const auto row = [&](std::size_t number) { return points.at(number * width); };
    const fused_rows::Neighbours<Real> around{
        {{row(1), row(2)}, {row(3), row(4)}, {row(5), row(6)}}};
    Points<float> normals(width);
    rows.normal({row(0), around, normals.first, static_cast<std::int64_t>(step), kCount});
    rows.limit({row(0), around, row(7), static_cast<std::int64_t>(step), kCount});
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
          limits_same &=
              same_bits(point(7)[axis], loop::limit(point(0)[axis], point(1)[axis] + point(2)[axis],
                                                    point(3)[axis] + point(4)[axis],
                                                    point(5)[axis] + point(6)[axis]));
        }
      }
    CHECK(normals_same);
    CHECK(limits_same);
  });
}

/// A base vertex and its ring, written down as the in-place rules say, one lane at a time.
template <class Real>
void check_fans(const fused_rows::OneRingRows<Real>& rows, bool loop_rule) {
  for (const int valence : {2, 3, 4, 5, 6, 7, 12, 40})
    for (const bool border : {false, true}) {
      if (valence == 2 && !border) continue;
      const auto n = static_cast<std::size_t>(valence);
      INFO("valence " << valence << (border ? ", border" : ""));
      for_all_points<Real>(2 * (n + 1), [&](Points<Real>& points) {
        rows.fan({points.at(0), points.at(n + 1), valence, border});
        bool same = true;
        for (std::size_t k = 0; k < kPointNumbers; ++k) {
          const auto old = [&](std::size_t point) { return points.at(point)[k]; };
          const auto made = [&](std::size_t point) { return points.at(n + 1 + point)[k]; };
          double sum = 0;
          for (std::size_t i = 1; i <= n; ++i) {
            const Real odd = border && (i == 1 || i == n)
                                 ? Real(0.5) * (old(0) + old(i))
                                 : odd_of(loop_rule, old(0), old(i), old(i == 1 ? n : i - 1),
                                          old(i == n ? 1 : i + 1));
            same &= same_bits(made(i), odd);
            sum += double(odd);
          }
          Real centre = old(0);
          if (loop_rule && border) {
            centre = Real(loop::even_border(double(old(0)), double(made(1)), double(made(n))));
          } else if (loop_rule) {
            const double weight = loop::odd_neighbour_weight(valence);
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
    const auto rows = loop_rows<TestType>();
    check_refining(rows, true);
    check_fans(rows, true);
  });
}

TEMPLATE_TEST_CASE("FusedRows_MidpointOnEveryTarget_HasTheBitsOfTheScalarRules", "", float,
                   double) {
  on_every_target([] {
    const auto rows = midpoint_rows<TestType>();
    check_refining(rows, false);
    check_fans(rows, false);
  });
}

TEMPLATE_TEST_CASE("FusedRows_SurfaceOnEveryTarget_HasTheBitsOfTheScalarRules", "", float, double) {
  on_every_target([] {
    for (const std::size_t step : {1u, 2u, 8u}) check_surface(loop_rows<TestType>(), step);
  });
}

TEST_CASE("FusedRows_TargetAfterTarget_AreDifferentFunctions") {
  std::vector<void (*)(const fused_rows::OddRow<float>&)> seen;
  on_every_target([&] { seen.push_back(loop_rows<float>().odd); });
  for (std::size_t i = 0; i < seen.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) CHECK(seen[i] != seen[j]);
}
