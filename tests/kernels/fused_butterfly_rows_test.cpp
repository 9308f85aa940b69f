// Butterfly's rows and rings on every instruction set of this machine: the bits of the scalar
// rules, number by number.
#include <vector>

#include "butterfly/stencils.h"
#include "fused/patch_lattice.h"
#include "kernels/row_points.h"
#include "rows/dispatched_rows.h"

using namespace plait;
using namespace plait::test;

namespace {

// The stencils of one number.
template <class Real, class... Reals>
Real odd(Real first, Reals... rest) {
  return butterfly::odd(Number<Real>{first}, Number<Real>{rest}...).v;
}
template <class Real>
Real odd_border(Real before, Real a, Real b, Real after) {
  using N = Number<Real>;
  return butterfly::odd_border(N{before}, N{a}, N{b}, N{after}).v;
}

/// Eight rows into every second point of a ninth, and even points beside them.
template <class Real>
void check_butterfly_refining(const ButterflyRows<Real>& rows) {
  for_all_points<Real>(10 * kCount, [&](Points<Real>& points) {
    const auto row = [&](std::size_t number) { return points.at(number * kCount); };
    Real* const to = row(8);
    const std::vector<Real> before(to, to + 2 * kCount * kPointNumbers);
    rows.odd({row(0), row(1), row(2), row(3), row(4), row(5), row(6), row(7), to, kCount});
    bool odd_same = true, even_same = true, others_untouched = true;
    for (std::size_t i = 0; i < kCount * kPointNumbers; ++i) {
      const std::size_t at = i + i / kPointNumbers * kPointNumbers;
      odd_same &= same_bits(to[at], odd(row(0)[i], row(1)[i], row(2)[i], row(3)[i], row(4)[i],
                                        row(5)[i], row(6)[i], row(7)[i]));
      others_untouched &= same_bits(to[at + kPointNumbers], before[at + kPointNumbers]);
    }
    rows.even({row(0), {}, to, kCount});
    for (std::size_t i = 0; i < kCount * kPointNumbers; ++i) {
      const std::size_t at = i + i / kPointNumbers * kPointNumbers;
      even_same &= same_bits(to[at], row(0)[i]);
      others_untouched &= same_bits(to[at + kPointNumbers], before[at + kPointNumbers]);
    }
    CHECK(odd_same);
    CHECK(even_same);
    CHECK(others_untouched);
  });
}

/// Two rings as for_each_spoke() counts them, one lane at a time: next to the vertex, two steps
/// out, and between the spokes.
template <class Real>
void check_butterfly_rings(const ButterflyRows<Real>& rows) {
  for (const int valence : {2, 3, 4, 5, 6, 7, 12, 40})
    for (const bool border : {false, true}) {
      INFO("valence " << valence << (border ? ", border" : ""));
      const RingShape shape{valence, border, 2};
      const std::size_t count = shape.points();
      for_all_points<Real>(2 * count, [&](Points<Real>& points) {
        rows.ring_step({points.at(0), points.at(count), valence, border});
        bool same = true;
        for (std::size_t k = 0; k < kPointNumbers; ++k) {
          using enum RingPart;
          const auto old = [&](RingPart ring, int i) { return points.at(shape.point(ring, i))[k]; };
          const auto made = [&](RingPart ring, int i) {
            return points.at(count + shape.point(ring, i))[k];
          };
          const Real v = points.at(0)[k];
          same &= same_bits(points.at(count)[k], v);
          std::vector<double> spokes(static_cast<std::size_t>(valence));
          butterfly::for_each_spoke_value(
              valence, double(v), [&](int i) { return double(old(kNear, i)); },
              [&](int i, double value) { spokes[static_cast<std::size_t>(i)] = value; });
          for (int i = 0; i < valence; ++i) {
            const bool on_border = border && (i == 0 || i == valence - 1);
            Real near = Real(spokes[static_cast<std::size_t>(i)]);
            if (on_border)
              near = odd_border(old(kNear, valence - 1 - i), v, old(kNear, i), old(kFar, i));
            else if (border || valence == 6)
              near = odd(v, old(kNear, i), old(kNear, i + 1), old(kNear, i - 1), old(kNear, i + 2),
                         old(kBetween, i - 1), old(kBetween, i), old(kNear, i - 2));
            same &= same_bits(made(kNear, i), near);
            same &= same_bits(made(kFar, i), old(kNear, i));
            if (border && i == valence - 1) continue;
            same &= same_bits(
                made(kBetween, i),
                odd(old(kNear, i), old(kNear, i + 1), v, old(kBetween, i), old(kNear, i - 1),
                    old(kFar, i + 1), old(kNear, i + 2), old(kFar, i)));
          }
        }
        CHECK(same);
        if (!border) return;
        const auto made = [&](RingPart ring, int i) {
          return points.at(count + shape.point(ring, i));
        };
        using enum RingPart;
        const int last = valence - 1;
        const Real* const v = points.at(count);
        bool continued = true;
        for (std::size_t k = 0; k < kPointNumbers; ++k) {
          const auto wing = [&](const Real* to, const Real* a, const Real* b, const Real* inside) {
            continued &= same_bits(to[k], butterfly::continued(a[k], b[k], inside[k]));
          };
          wing(made(kNear, -1), v, made(kNear, 0), made(kNear, 1));
          wing(made(kNear, valence), v, made(kNear, last), made(kNear, last - 1));
          wing(made(kBetween, -1), made(kNear, 0), made(kFar, 0), made(kBetween, 0));
          wing(made(kBetween, last), made(kNear, last), made(kFar, last), made(kBetween, last - 1));
        }
        CHECK(continued);
      });
    }
}

}  // namespace

TEMPLATE_TEST_CASE("FusedRows_ButterflyOnEveryTarget_HasTheBitsOfTheScalarRules", "", float,
                   double) {
  on_every_target([] {
    check_butterfly_refining(butterfly_rows<TestType>());
    check_butterfly_rings(butterfly_rows<TestType>());
  });
}
