// remesh/tolerance_search.h: how near to all levels of a remeshed scan remesh() prunes, so that
// what is left is near enough to the scan.
#pragma once

#include <algorithm>

#include "plait/detail/namespace.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Smaller and smaller tolerances. All levels are at most `limit` from the scan, and what is left
/// of them is measured. Two distances add up at worst, but seldom at the same place, so the first
/// tolerance is the whole limit. Pinned by tests/jobs/remesh_depths_test.cpp.
class ToleranceSearch {
 public:
  /// `all_levels`: how far these are from the scan, at most `limit`.
  ToleranceSearch(double limit, double all_levels)
      : limit_(limit), all_levels_(all_levels), tolerance_(limit) {}

  double tolerance() const { return tolerance_; }
  /// Goes on after a trial whose result was `found` from the scan, farther than the limit: to what
  /// would be near enough if distances grow with the tolerance, between a quarter and nine tenths
  /// of the last one. After kTrials, to 0: all levels stay.
  void next(double found) {
    const double share = (limit_ - all_levels_) / (found - all_levels_);
    tolerance_ = ++trials_ < kTrials ? tolerance_ * std::clamp(0.95 * share, 0.25, 0.9) : 0;
  }

 private:
  static constexpr int kTrials = 6;
  double limit_, all_levels_, tolerance_;
  int trials_ = 0;
};

PLAIT_END_NAMESPACE
