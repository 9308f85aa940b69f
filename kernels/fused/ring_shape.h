// How a base vertex and the rings around it are numbered.
#pragma once

#include <cstddef>

namespace plait {

/// The rings that a rule reads around a base vertex, by where a point of them lies.
enum class RingPart {
  kNear,     ///< next to the vertex on spoke i
  kFar,      ///< two steps out on spoke i
  kBetween,  ///< two steps out, between spokes i and i + 1
};

/// Point 0 is the vertex itself; then come the rings, kNear alone for a reach of one, all three for
/// a reach of two. Spokes count counterclockwise, on a border from border to border; with a reach
/// of two a border vertex has one spoke more on either side, whose points lie beyond the border.
struct RingShape {
  int valence = 0;
  bool border = false;
  int reach = 1;

  constexpr int beyond() const { return border && reach > 1 ? 1 : 0; }
  constexpr std::size_t points() const {
    return 1 + (reach > 1 ? 3 : 1) * static_cast<std::size_t>(width());
  }
  /// Spokes follow one another; where a border leaves none the vertex itself stands in.
  /// REQUIRES: no more than one turn beyond 0 to valence - 1.
  constexpr std::size_t point(RingPart ring, int spoke) const {
    if (!border)
      spoke += spoke < 0 ? valence : spoke >= valence ? -valence : 0;
    else if (spoke < -beyond() || spoke >= valence + beyond())
      return 0;
    spoke += beyond();
    return 1 + static_cast<std::size_t>(ring) * static_cast<std::size_t>(width()) +
           static_cast<std::size_t>(spoke);
  }
  /// The first of the vertex's own neighbours, which follow one another.
  constexpr std::size_t first_neighbour() const { return border && reach > 1 ? 2 : 1; }

 private:
  constexpr int width() const { return valence + 2 * beyond(); }
};

}  // namespace plait
