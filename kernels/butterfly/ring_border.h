// Computes the points beyond the two border edges of a border vertex, which Butterfly stencils
// read.
#pragma once

#include <cstddef>

#include "butterfly/stencils.h"
#include "fused/ring_shape.h"
#include "plait/detail/rows.h"

namespace plait::butterfly {

/// Continues the rings of border vertices, one in each lane, beyond the first and the last spoke.
template <class Real>
void continue_ring(int valence, Real* points) {
  using enum RingPart;
  const RingShape shape{valence, true, 2};
  const auto at = [&](RingPart ring, int spoke) {
    return points + shape.point(ring, spoke) * kPointNumbers;
  };
  const auto put = [](Real* to, const Real* end0, const Real* end1, const Real* inside) {
    for (std::size_t k = 0; k < kPointNumbers; ++k) to[k] = continued(end0[k], end1[k], inside[k]);
  };
  const int last = valence - 1;
  put(at(kNear, -1), points, at(kNear, 0), at(kNear, 1));
  put(at(kNear, valence), points, at(kNear, last), at(kNear, last - 1));
  put(at(kBetween, -1), at(kNear, 0), at(kFar, 0), at(kBetween, 0));
  put(at(kBetween, last), at(kNear, last), at(kFar, last), at(kBetween, last - 1));
}

}  // namespace plait::butterfly
