// A buffer for the numbers of a patch lattice, with one patch in each lane.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <new>

#include "plait/detail/rows.h"
#include "plait/extend/fused.h"
#include "plait/extend/vector3.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

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
PLAIT_END_NAMESPACE
