// layout/hilbert_cells.h: where a face is on the Hilbert curve of its mesh. The order in memory
// (face_order.cpp) and the one in files (jobs/layout/) take the same steps.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "layout/hilbert.h"
#include "plait/detail/namespace.h"
#include "plait/extend/vector3.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// The bounding box of vertices that come one after another.
class GrowingBox {
 public:
  void add(const Vector3<double>& p) {
    if (is_empty_) lowest_ = highest_ = p;
    is_empty_ = false;
    for (int axis = 0; axis < 3; ++axis) {
      lowest_[axis] = std::min(lowest_[axis], p[axis]);
      highest_[axis] = std::max(highest_[axis], p[axis]);
    }
  }
  // All coordinates are halved: so differences of finite positions do not overflow.
  Vector3<double> halved_lowest() const { return 0.5 * lowest_; }
  Vector3<double> halved_extent() const { return 0.5 * highest_ - 0.5 * lowest_; }

 private:
  Vector3<double> lowest_{}, highest_{};
  bool is_empty_ = true;
};

inline double centroid(const Vector3<double>& a, const Vector3<double>& b, const Vector3<double>& c,
                       int axis) {
  return a[axis] / 3 + b[axis] / 3 + c[axis] / 3;
}

/// The cells of the curve through a box.
class HilbertCells {
 public:
  explicit HilbertCells(const GrowingBox& box) : lowest_(box.halved_lowest()) {
    const Vector3<double> extent = box.halved_extent();
    // All axes have the same scale, so cells are cubes. This keeps neighbours on the curve close in
    // space.
    size_ = std::max({extent.x, extent.y, extent.z});
  }

  /// The key of the cell of a face's centroid.
  std::uint64_t key(const Vector3<double>& a, const Vector3<double>& b,
                    const Vector3<double>& c) const {
    constexpr double kLastCell = (1 << layout::kHilbertBits) - 1;
    std::array<std::uint32_t, 3> cell{};
    for (int axis = 0; axis < 3; ++axis) {
      const double offset = 0.5 * centroid(a, b, c, axis) - lowest_[axis];
      // Rounding may put a centroid a little outside the box. If the box has no size, every cell is
      // 0.
      if (offset > 0)
        cell[static_cast<std::size_t>(axis)] =
            static_cast<std::uint32_t>(std::min(offset / size_, 1.0) * kLastCell);
    }
    return layout::hilbert_key(cell);
  }

 private:
  Vector3<double> lowest_;
  double size_ = 0;
};

PLAIT_END_NAMESPACE
