// Every instruction set that this processor has, one after another: for tests and measurements of
// what is compiled for each of them.
#pragma once

#include <hwy/targets.h>

#include <cstdint>

namespace plait::fused_rows {

/// Makes dynamic dispatch choose one instruction set after another, the narrowest first, calling
/// visit(name) under each, and lets it choose the best one again. Not while other threads dispatch.
template <class Visit>
void on_every_target(Visit visit) {
  const auto choose_among = [](std::int64_t targets) {
    hwy::SetSupportedTargetsForTest(targets);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  };
  choose_among(0);  // all that there are
  const std::int64_t all = hwy::SupportedTargets() & HWY_TARGETS;
  // Wider instruction sets have lower bits.
  for (int bit = 62; bit >= 0; --bit) {
    const std::int64_t target = std::int64_t{1} << bit;
    if ((all & target) == 0) continue;
    choose_among(target);
    visit(hwy::TargetName(target));
  }
  choose_among(0);
}

}  // namespace plait::fused_rows
