// remesh/distance_search.h: which base mesh and level remesh() tries next, to come within a
// distance.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "plait/detail/namespace.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Base meshes of more and more faces, the last of which is the scan. Pinned by
/// tests/jobs/remesh_test.cpp.
class DistanceSearch {
 public:
  /// `first_faces` of the first base mesh; 0: a thousandth of the scan's.
  DistanceSearch(std::uint64_t scan_faces, std::uint64_t first_faces, int levels)
      : scan_faces_(scan_faces),
        faces_(first_faces > 0
                   ? std::min(first_faces, scan_faces)
                   : std::min(std::max(kFewestFaces, scan_faces / kFirstShare), scan_faces)),
        most_levels_(levels) {}

  std::uint64_t faces() const { return faces_; }
  /// Fewer than asked for where there would be more than four small faces for each of the scan.
  int levels() const {
    int levels = most_levels_;
    while (levels > 1 && faces_ << (2 * levels) > kMostSmallFaces * scan_faces_) --levels;
    return levels;
  }
  /// Goes on after a trial whose largest distance was `ratio` times the limit: to as many faces as
  /// make it small enough on a smooth surface, or sixteen times as many. Returns false if the scan
  /// was the base mesh.
  bool next(double ratio) {
    if (faces_ == scan_faces_) return false;
    const double doublings = std::clamp(std::ceil(std::log2(ratio)), 1.0, kMostDoublings);
    faces_ = std::min(scan_faces_, faces_ << static_cast<int>(doublings));
    return true;
  }

 private:
  static constexpr std::uint64_t kFirstShare = 1000, kFewestFaces = 16;
  static constexpr std::uint64_t kMostSmallFaces = 4;  ///< for each of the scan
  static constexpr double kMostDoublings = 4;

  std::uint64_t scan_faces_, faces_;
  int most_levels_;
};

PLAIT_END_NAMESPACE
