// fused/patch_lattice.h: the vertices of a patch at one level, with the ring around it.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <new>
#include <vector>

#include "plait/detail/namespace.h"
#include "plait/detail/rows.h"
#include "plait/extend/edge_index.h"
#include "plait/extend/fused.h"
#include "plait/extend/topology.h"
#include "plait/extend/vector3.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

// Points along the sides of a patch, and the steps from one corner towards another.

/// The point of `side` with this weight at its start.
constexpr FaceIndex on_side(int level, int side, std::int64_t weight) {
  std::int64_t k[3] = {};
  k[(side + 1) % 3] = weight;
  k[(side + 2) % 3] = (std::int64_t{1} << level) - weight;
  return {0, level, k[1], k[2]};
}

struct LatticeStep {
  std::int64_t i, j;
};
/// The step that moves one unit of weight to corner `to` from corner `from`.
constexpr LatticeStep step(int to, int from) {
  return {std::int64_t(to == 1) - std::int64_t(from == 1),
          std::int64_t(to == 2) - std::int64_t(from == 2)};
}

// A buffer for the numbers of a patch lattice, with one patch in each lane.

/// Scratch memory, aligned to vectors. Results of lanes without a patch, and of points beyond
/// borders, are ignored.
template <class Number>
class LatticeBuffer {
 public:
  explicit LatticeBuffer(std::int64_t points) : points_(points) {
    const std::size_t count = static_cast<std::size_t>(points) * kPointNumbers;
    numbers_.reset(
        static_cast<Number*>(::operator new(count * sizeof(Number), std::align_val_t(kAlignment))));
    std::fill_n(numbers_.get(), count, Number(0));
  }
  Number* data() const { return numbers_.get(); }
  std::int64_t points() const { return points_; }

 private:
  static constexpr std::size_t kAlignment = 64;
  struct Free {
    void operator()(Number* numbers) const {
      ::operator delete(numbers, std::align_val_t(kAlignment));
    }
  };
  std::int64_t points_;
  std::unique_ptr<Number, Free> numbers_;
};

namespace lattice_points {

/// The numbers of a point.
template <class Number>
Number* at(Number* numbers, const PatchLattice& lattice, std::int64_t i, std::int64_t j) {
  return numbers + lattice.index(i, j) * static_cast<std::int64_t>(kPointNumbers);
}

/// One lane of a point.
template <class Number>
Vector3<Number> get(const Number* point, std::size_t lane) {
  return {point[lane], point[kPatchLanes + lane], point[2 * kPatchLanes + lane]};
}
template <class Number>
void put(Number* point, std::size_t lane, const Vector3<Number>& v) {
  point[lane] = v.x;
  point[kPatchLanes + lane] = v.y;
  point[2 * kPatchLanes + lane] = v.z;
}

}  // namespace lattice_points

// Finds the rows of the six neighbours of a row of points.

/// The pairs of opposite neighbours, in the order of the frame of `side`.
template <class Real>
inline Neighbours<Real> neighbours(const Real* numbers, const PatchLattice& lattice, std::int64_t i,
                                   std::int64_t j, int side) {
  const int start = (side + 1) % 3, end = (side + 2) % 3;
  const auto pair = [&](LatticeStep s, std::size_t which, Neighbours<Real>& to) {
    to.pairs[which][0] = lattice_points::at(numbers, lattice, i + s.i, j + s.j);
    to.pairs[which][1] = lattice_points::at(numbers, lattice, i - s.i, j - s.j);
  };
  Neighbours<Real> result;
  pair(step(start, side), 0, result);
  pair(step(end, side), 1, result);
  pair(step(end, start), 2, result);
  return result;
}

// The numbering of a base vertex and the points of the rings around it.

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
    if (!border)  // and then no branch, which processors would predict badly
      spoke += valence * (int{spoke < 0} - int{spoke >= valence});
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
