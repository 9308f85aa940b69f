// From the lanes of a refined group of patches to the slots of their edges, and from there to where
// the blocks are.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "execution/slot_bundle.h"
#include "plait/fused.h"

namespace plait {

/// Where a group's patches put what they have of their sides.
struct GroupTargets {
  struct Target {
    std::byte* bundle = nullptr;  ///< nullptr: no patch in this lane
    bool own = false, border = false;
  };
  std::array<std::array<Target, kPatchLanes>, 3> sides;  ///< [side][lane]
};

/// Stores one output's points, as PatchRefiner::points() gives them, into the bundles: from the own
/// face of an edge also the points on the edge itself. `spare` takes what nobody wants: one record.
void scatter_to_bundles(const void* points, const PatchLattice& lattice, const BundleShape& shape,
                        std::size_t output, const GroupTargets& targets, std::byte* spare);

/// Copies `records` records from a bundle to their slot. `streaming` bypasses the caches.
void copy_to_slot(const BundleShape::Output& shape, const std::byte* bundle, std::uint64_t records,
                  bool streaming, std::byte* slot);
/// Makes streamed copies visible to other threads.
void finish_streaming();

}  // namespace plait
