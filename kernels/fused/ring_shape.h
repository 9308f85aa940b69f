// The numbering of a base vertex and the points of the rings around it.
#pragma once

#include <cstddef>

#include "plait/detail/namespace.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// The parts of the rings that a rule reads around a base vertex.
enum class RingPart {
  kNear,     ///< next to the vertex on spoke i
  kFar,      ///< two steps out on spoke i
  kBetween,  ///< two steps out, between spokes i and i + 1
};

/// Point 0 is the vertex itself. Then come the points of the rings: kNear alone for a scheme of one
/// ring, all three parts for a scheme of two rings. Spokes are numbered counterclockwise; at a
/// border vertex they go from border to border. With two rings, a border vertex has one more spoke
/// on either side, and the points of these spokes lie beyond the border.
struct RingShape {
  int valence = 0;
  bool border = false;
  int ring_count = 1;

  constexpr int beyond() const { return border && ring_count > 1 ? 1 : 0; }
  constexpr std::size_t points() const {
    return 1 + (ring_count > 1 ? 3 : 1) * static_cast<std::size_t>(width());
  }
  /// The number of the point on `spoke`. Around an inner vertex, spoke numbers wrap around. If a
  /// border vertex has no such spoke, the result is the vertex itself. REQUIRES: `spoke` is at most
  /// one turn outside 0 to valence - 1.
  constexpr std::size_t point(RingPart ring, int spoke) const {
    if (!border)
      spoke += spoke < 0 ? valence : spoke >= valence ? -valence : 0;
    else if (spoke < -beyond() || spoke >= valence + beyond())
      return 0;
    spoke += beyond();
    return 1 + static_cast<std::size_t>(ring) * static_cast<std::size_t>(width()) +
           static_cast<std::size_t>(spoke);
  }
  /// The number of the vertex's first neighbour. The other neighbours follow it.
  constexpr std::size_t first_neighbour() const { return border && ring_count > 1 ? 2 : 1; }

 private:
  constexpr int width() const { return valence + 2 * beyond(); }
};

PLAIT_END_NAMESPACE
