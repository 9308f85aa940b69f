// Loop's rules at one base vertex, of any valence, from its ring. Evaluated in double: a sum over a
// hundred thousand neighbours has no digits left in float.
#pragma once

#include "loop/loop_expressions.h"
#include "plait/vector3.h"

namespace plait::loop {

struct BaseRing {
  int valence = 0;
  Vector3<double> sum{}, first{}, last{};
};

/// Where a base vertex moves to; `ring` holds the new odd vertices around it.
inline Vector3<double> moved_base(const BaseRing& ring, bool border, const Vector3<double>& v) {
  if (border) return by_axis<double>(even_border<double>, v, ring.first, ring.last);
  const double weight = odd_neighbour_weight(ring.valence);
  return (1 - ring.valence * weight) * v + weight * ring.sum;
}

/// Limit position of a base vertex; `ring` is the finest level's.
inline Vector3<double> limit_of_base(const BaseRing& ring, bool border, const Vector3<double>& v) {
  if (border) return by_axis<double>(limit_border<double>, v, ring.first, ring.last);
  const double weight = limit_weight(ring.valence);
  return (1 - ring.valence * weight) * v + weight * ring.sum;
}

}  // namespace plait::loop
