// plait/pin_needs.h: what the passes of the sweep and of the transparent executor will pin at
// once, told before the levels exist.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "plait/store.h"
#include "plait/sweep.h"

namespace plait {

/// Levels of one attribute that a pass reads or writes. Levels count from the user's mesh; those
/// that the base mesh of the store has already need no frame.
struct AccessedLevels {
  std::size_t record_bytes = 0;
  int first_level = 1, last_level = 0;  ///< nothing if last < first
  Reach reach = Reach::kOwn;
};

/// Bytes of frames that a sweep with these accesses pins at its widest place: the smallest budget
/// that does, as sweep_window_bytes() tells of levels that exist.
/// Pinned by tests/engine/execution/pin_needs_test.cpp.
std::uint64_t sweep_needs(const Store& store, std::span<const AccessedLevels> accesses,
                          int threads);

/// Bytes of frames that one face pins at the widest place, of one attribute: what its PinnedPatch
/// holds whatever its share of the budget is. Pinned by the same test.
std::uint64_t patch_needs(const Store& store, const AccessedLevels& access);

}  // namespace plait
