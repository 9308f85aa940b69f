// plait/detail/slot_shapes.h: which records of an edge's grid exist, and so have a place in its
// slot.
//
// An edge's grid at one level is the square between its two faces. If only one of the faces has
// this level, only half of the square exists. If neither face has it, the slot is absent. In a
// store without depths (docs/adaptive.md) every face has every level, so only border edges have
// half slots, and no slot is absent. Code asks the slot for its shape, and never the edge.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "plait/detail/edge_set.h"
#include "plait/detail/namespace.h"
#include "plait/extend/edge_index.h"
#include "plait/extend/topology.h"

PLAIT_BEGIN_NAMESPACE

/// The records of a slot in memory, row by row. An absent slot has none.
template <class Record>
struct SlotRecords {
  std::span<Record> records;
  SlotShape shape = SlotShape::kWhole;

  Record* data() const noexcept { return records.data(); }
  /// REQUIRES: the slot has this record.
  Record& at(int level, std::int64_t row, std::int64_t column) const noexcept {
    return records[static_cast<std::size_t>(slot_position(level, shape, row, column))];
  }
};

/// A slot in memory. An absent slot has no bytes.
struct LocatedSlot {
  std::span<std::byte> bytes;
  SlotShape shape = SlotShape::kWhole;

  template <class Record>
  SlotRecords<Record> of() const noexcept {
    return {{reinterpret_cast<Record*>(bytes.data()), bytes.size() / sizeof(Record)}, shape};
  }
};

/// How a kernel goes through the rows of a slot. The shape says how many records a row has; the
/// mesh says whether the last one of each row is on a border, where rules are others.
struct SlotRows {
  SlotShape shape = SlotShape::kWhole;
  bool border = false;  ///< only of a half slot

  /// Records of row `row`, of n rows.
  std::int64_t records(std::int64_t n, std::int64_t row) const noexcept {
    return row_records(shape, n, row);
  }
  /// Those of them that are not on a border.
  std::int64_t inside(std::int64_t n, std::int64_t row) const noexcept {
    return records(n, row) - (border ? 1 : 0);
  }
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
  /// Those of a mesh in which every face has every level.
  explicit SlotShapes(const Topology& mesh)
      : SlotShapes(mesh.edges.size(), EdgeSet(mesh.border_edges)) {}

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
