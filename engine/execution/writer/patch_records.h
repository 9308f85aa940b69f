// Copies the records of a patch to its slots, and compares those that two patches have.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "plait/detail/face_slots.h"
#include "plait/extend/topology.h"
#include "plait/reader.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// The grid of a patch in row order, as a caller gives it.
struct PatchRecords {
  const std::byte* records;
  std::size_t record_bytes;
  int level;  ///< of the grid: how often the base mesh is refined

  std::int64_t size() const { return std::int64_t{1} << level; }
  /// Begins to load a patch that is not larger than the processor's first cache. The copy then
  /// walks along its columns.
  void prefetch(std::size_t bytes) const {
    constexpr std::size_t kCacheLine = 64, kCacheBytes = std::size_t{32} << 10;
    if (bytes > kCacheBytes) return;
    for (std::size_t at = 0; at < bytes; at += kCacheLine) __builtin_prefetch(records + at);
  }
  const std::byte* at(std::int64_t i, std::int64_t j) const {
    return records + static_cast<std::size_t>(patch_vertex(size(), i, j)) * record_bytes;
  }
};

/// Copies the vertices that refinements `from` to patch.level create. `with_edge[side]`: those on
/// this side too.
void copy_inside(const PatchRecords& patch, int from, const std::array<bool, 3>& with_edge,
                 const FaceSlots& slots);

/// Copies the corners that the face owns.
void copy_own_corners(const PatchRecords& patch, const Topology& mesh, FaceId face,
                      const FaceSlots& slots);

/// Calls visit(i, j) for the vertices on a side of the grid that refinement `born` creates.
template <class Visit>
void for_each_on_side(const PatchRecords& patch, int side, int born, Visit visit) {
  const std::int64_t size = patch.size(), step = std::int64_t{1} << (patch.level - born);
  for (std::int64_t at = step; at < size; at += 2 * step)
    side == 0 ? visit(size - at, at) : side == 1 ? visit(0, at) : visit(at, 0);
}

PLAIT_END_NAMESPACE
