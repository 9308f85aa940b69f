// plait/extend/in_core_mesh.h: a semi-regular mesh in plain arrays, as a program without plait
// would keep it. The benchmarks compare the transparent executor with it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "plait/base_mesh.h"
#include "plait/detail/namespace.h"
#include "plait/detail/patch_table.h"
#include "plait/extend/edge_index.h"

PLAIT_BEGIN_NAMESPACE

/// Satisfies PatchMesh. Each level has one array of n x n records per edge; a border edge uses only
/// the triangle of its array. For one thread. The mesh must not be moved while one of its patches
/// is in use.
template <class RecordType>
class InCoreMesh {
 public:
  using Record = RecordType;

  using Patch = TabledPatch<InCoreMesh>;

  /// Level 0 is `base`, which must outlive this object. Base records are zeros at first.
  InCoreMesh(const BaseMesh& base, int levels)
      : topology_(base.topology()), base_records_(base.vertex_count()) {
    for (int level = 1; level <= levels; ++level)
      levels_.emplace_back(base.edge_count() * slot_records(level));
    table_.set_levels(0, BaseRelativeLevel(levels));
  }

  const Topology& topology() const { return topology_; }
  std::span<Record> base_records() { return base_records_; }
  void activate(int, int, int) {}
  /// Makes `face` the current patch. The previous patch must not be used any more.
  Patch patch(FaceId face) {
    table_.enter(topology_, face, sizeof(Record), true,
                 reinterpret_cast<std::byte*>(base_records_.data()),
                 [&](EdgeId edge, BaseRelativeLevel level) {
                   return LocatedSlot{std::as_writable_bytes(slot(edge, level.refinements)),
                                      SlotShape::kWhole};
                 });
    return Patch(*this);
  }

 private:
  friend Patch;

  const PatchTable& table() const { return table_; }
  /// The record at a point of any face.
  Record& anywhere(const FaceIndex& point) {
    if (is_corner(point.level, point.i, point.j))
      return base_records_[topology_.faces[point.face]
                                          [static_cast<std::size_t>(corner_of(point.i, point.j))]];
    const EdgeIndex index = edge_index(topology_, point);
    return slot(index.edge, index.level)[static_cast<std::size_t>(
        slot_position(index.level, SlotShape::kWhole, index.row, index.column))];
  }
  std::span<Record> slot(EdgeId edge, int level) {
    return std::span(levels_[static_cast<std::size_t>(level - 1)])
        .subspan(edge * slot_records(level), slot_records(level));
  }

  Topology topology_;
  std::vector<Record> base_records_;
  std::vector<std::vector<Record>> levels_;
  PatchTable table_;
};

PLAIT_END_NAMESPACE
