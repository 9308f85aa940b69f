// From the lanes of a refined group of patches to the slots of their edges, and from there to where
// the blocks are.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

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

/// Stores points, as PatchRefiner::points() gives them, into bundles: from the own face of an edge
/// also the points on the edge itself. Immutable; safe from any number of threads.
class SlotScatter {
 public:
  /// `shape` must outlive this object.
  SlotScatter(const PatchLattice& lattice, const BundleShape& shape);

  /// `spare` takes what nobody wants: one record.
  void operator()(std::size_t output, const void* points, const GroupTargets& targets,
                  std::byte* spare) const;

  /// A slot's row through the lattice, in bytes: the points follow a parabola, since the rows of a
  /// lattice become shorter. `inner` points, and then the one on the edge.
  struct Path {
    std::ptrdiff_t first, step, step_change;
    std::int64_t inner;
  };

 private:
  const BundleShape& shape_;
  std::vector<std::vector<Path>> paths_;  ///< [output][level, side, row]
};

/// Copies `records` records from a bundle to their slot. `streaming` bypasses the caches.
void copy_to_slot(const BundleShape::Output& shape, const std::byte* bundle, std::uint64_t records,
                  bool streaming, std::byte* slot);
/// Makes streamed copies visible to other threads.
void finish_streaming();

}  // namespace plait
