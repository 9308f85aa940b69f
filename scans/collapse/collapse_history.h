// collapse/collapse_history.h: the collapses of edges that led from a scan to its base mesh, and
// the way back for a point: successive self-parametrisation (A. Lee, W. Sweldens, P. Schröder, L.
// Cowsar, D. Dobkin, "MAPS: multiresolution adaptive parameterization of surfaces", 1998; H.-T. D.
// Liu et al., "Neural subdivision", 2020).
//
// A collapse replaces the faces around an edge by a fan of faces around one vertex. Both fill the
// same polygon in the plane. So a point of the fan is a point of exactly one of the old faces.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

#include "collapse/patch.h"
#include "plait/detail/namespace.h"
#include "surface/surface.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

class CollapseHistory {
 public:
  /// A history without collapses of a surface with `faces` faces. With `keeps_lines`, points of
  /// creases stay on them without rounding.
  explicit CollapseHistory(std::size_t faces, bool keeps_lines = false)
      : last_(faces, kNone), keeps_lines_(keeps_lines), mutex_(std::make_unique<std::mutex>()) {}

  static constexpr std::size_t kBlockWords = std::size_t{1} << 18;

  /// Where a thread writes records.
  struct Room {
    std::uint32_t* block = nullptr;
    std::uint32_t first = 0;         ///< place of the block's first word
    std::size_t used = kBlockWords;  ///< words of the block
  };
  /// Adds a collapse, whose plane is laid out. From now on its fan's faces lead back through it.
  /// Threads: any number, with rooms of their own, if their patches have no face in common.
  void add(const Patch& patch, const PatchPlane& plane, Room& room);

  /// The point of the first surface that belongs to a point of the present one. Threads: any
  /// number. Pinned by tests/scans/collapse_history_test.cpp.
  SurfacePoint follow_back(SurfacePoint point) const;

  std::uint64_t collapse_count() const { return collapses_; }
  std::uint64_t memory_bytes() const;

 private:
  // A record is a row of words: shape, apexes, the plane points of the two old vertices, those of
  // the ring, for each face its corner at the old vertex, and for each face the record before this
  // one.
  static constexpr std::uint32_t kNone = kNoId;

  const std::uint32_t* record(std::uint32_t place) const {
    return blocks_[place / kBlockWords].get() + place % kBlockWords;
  }

  std::vector<std::unique_ptr<std::uint32_t[]>> blocks_;  // never moved while they grow
  std::vector<std::uint32_t> last_;                       // [face] its newest record
  bool keeps_lines_;
  std::unique_ptr<std::mutex> mutex_;  // of blocks_
  std::uint64_t collapses_ = 0;
};

PLAIT_END_NAMESPACE
