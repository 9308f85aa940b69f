// plait/slot_shapes.h: which records of an edge's grid exist, and so have a place in its slot.
//
// An edge's grid at one level is the square between its two faces. If only one of the faces has
// this level, only half of the square exists. If neither face has it, the slot is absent. Today
// every face has every level, so only border edges have half slots, and no slot is absent.
// docs/adaptive.md tells what changes if faces are refined to different depths.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "plait/edge_set.h"
#include "plait/namespace.h"

PLAIT_BEGIN_NAMESPACE

enum class SlotShape : std::uint8_t {
  kWhole,   ///< n x n records, n = 2^(level-1)
  kHalf,    ///< n(n+1)/2 records: the triangle of the one face that has the level
  kAbsent,  ///< none: the slot has no bytes
};

/// A slot in memory. An absent slot has no bytes.
struct LocatedSlot {
  std::span<std::byte> bytes;
  SlotShape shape = SlotShape::kWhole;
};

/// The shapes of the slots of all edges. Immutable and cheap to copy; safe from any number of
/// threads.
class SlotShapes {
 public:
  /// `edge_count` whole slots.
  explicit SlotShapes(std::uint64_t edge_count = 0) : edge_count_(edge_count) {}
  /// Slots are half for the edges of `half`, absent for those of `absent` and whole for all others.
  /// Errors: kInvalidArgument for edges from `edge_count` on, and for an edge of both sets.
  SlotShapes(std::uint64_t edge_count, EdgeSet half, EdgeSet absent = {});

  std::uint64_t edge_count() const noexcept { return edge_count_; }
  /// Edges whose slots are not absent.
  std::uint64_t slot_count() const noexcept { return edge_count_ - absent_.size(); }
  const EdgeSet& half() const noexcept { return half_; }
  const EdgeSet& absent() const noexcept { return absent_; }
  SlotShape shape(EdgeId edge) const noexcept {
    if (half_.contains(edge)) return SlotShape::kHalf;
    return absent_.contains(edge) ? SlotShape::kAbsent : SlotShape::kWhole;
  }
  std::uint64_t memory_bytes() const noexcept {
    return half_.memory_bytes() + absent_.memory_bytes();
  }

 private:
  std::uint64_t edge_count_;
  EdgeSet half_, absent_;
};

PLAIT_END_NAMESPACE
