// Runs code with every instruction set of this processor, one after another. For tests and
// measurements of the row functions.
#pragma once

#include <hwy/targets.h>

#include <cstdint>

namespace plait::fused_rows {

/// Makes dynamic dispatch choose each instruction set in turn, the narrowest first, and calls
/// visit(name). At the end, dispatch chooses the best one again. REQUIRES: no other thread calls
/// row functions at the same time.
template <class Visit>
void on_every_target(Visit visit) {
  const auto choose_among = [](std::int64_t targets) {
    hwy::SetSupportedTargetsForTest(targets);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  };
  choose_among(0);  // all of them
  const std::int64_t all = hwy::SupportedTargets() & HWY_TARGETS;
  // In Highway, wider instruction sets have lower bits.
  for (int bit = 62; bit >= 0; --bit) {
    const std::int64_t target = std::int64_t{1} << bit;
    if ((all & target) == 0) continue;
    choose_among(target);
    visit(hwy::TargetName(target));
  }
  choose_among(0);
}

}  // namespace plait::fused_rows
