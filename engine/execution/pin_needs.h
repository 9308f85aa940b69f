// execution/pin_needs.h: computes how much memory a pass of the sweep or of the transparent
// executor will pin at once. The levels need not exist yet.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "plait/detail/namespace.h"
#include "plait/extend/level_geometry.h"
#include "plait/extend/sweep.h"
#include "plait/store.h"

PLAIT_BEGIN_NAMESPACE

/// Levels of one attribute that a pass reads or writes. Levels count from the user's mesh. Levels
/// up to the base level of the store need no frame.
struct AccessedLevels {
  std::size_t record_bytes = 0;
  int first_level = 1, last_level = 0;  ///< nothing if last < first
  Reach reach = Reach::kOwn;
};

/// The same levels by where their blocks are, from coarse to fine.
struct AccessedGeometries {
  std::vector<LevelGeometry> levels;
  Reach reach;
};

/// The most bytes of frames that a sweep pins at once over levels with these geometries.
std::uint64_t window_needs(const Store& store, std::vector<AccessedGeometries> accesses,
                           int threads);
/// The same for levels that the store need not have. This is the smallest budget for the sweep.
/// Pinned by tests/engine/execution/pin_needs_test.cpp.
std::uint64_t sweep_needs(const Store& store, std::span<const AccessedLevels> accesses,
                          int threads);

/// The most bytes of frames that a PinnedPatch of one attribute pins for one face. It pins them
/// even if its share of the budget is smaller. Pinned by the same test.
std::uint64_t patch_needs(const Store& store, const AccessedLevels& access);

PLAIT_END_NAMESPACE
