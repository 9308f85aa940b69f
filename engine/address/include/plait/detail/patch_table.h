// plait/detail/patch_table.h: the addresses of the records of one base face and of the faces across
// its sides. enter() looks up the slots once for each face, so at(level, i, j) takes only a few
// instructions.
//
// A face at a level is a grid with corners (0, 0), (size, 0) and (0, size), size = 2^k, where k
// counts how often the base mesh is refined to reach that level. Level numbers count from the
// user's mesh.
//
// The table numbers the sides of a face across side x so that the common edge is its side x too. A
// point beyond side x then has the weights size - k(x+1), size - k(x+2) and -k(x) in that face.
// Pinned by tests/engine/execution/patch_test.cpp.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "plait/detail/face_slots.h"
#include "plait/detail/namespace.h"
#include "plait/detail/slot_shapes.h"
#include "plait/extend/base_relative_level.h"
#include "plait/extend/edge_index.h"
#include "plait/extend/topology.h"

PLAIT_BEGIN_NAMESPACE

/// For one thread. The caller must keep the slots that it passes in at their addresses while it
/// uses the table.
class PatchTable {
 public:
  FaceId face() const { return face_; }
  bool owns(int side) const { return (owned_ >> side & 1) != 0; }
  bool is_border(int side) const { return (borders_ >> side & 1) != 0; }

  /// Sets the levels of the table: the level of the base mesh, and `finest` refinements of it.
  void set_levels(int base_level, BaseRelativeLevel finest) {
    base_level_ = base_level;
    finest_ = finest;
  }
  /// Whether the table has `level`.
  [[gnu::always_inline]] bool has(int level) const {
    return static_cast<unsigned>(level - base_level_) <= static_cast<unsigned>(finest_.refinements);
  }
  /// REQUIRES: has(level). This holds for all functions below that take a level.
  [[gnu::always_inline]] BaseRelativeLevel relative(int level) const {
    return relative_to_base(level, base_level_);
  }
  [[gnu::always_inline]] std::int64_t size(int level) const {
    return std::int64_t{1} << relative(level).refinements;
  }

  /// Makes `face` current. `base` is the address of the base vertices' records. The table calls
  /// `locate(edge, BaseRelativeLevel)`, which gives a LocatedSlot, once per edge and level.
  /// `with_neighbours` adds the faces across the sides.
  template <class Locate>
  void enter(const Topology& mesh, FaceId face, std::size_t record_bytes, bool with_neighbours,
             std::byte* base, Locate locate);

  /// Address of a point of the face. REQUIRES: it is in the face.
  [[gnu::always_inline]] std::byte* inside(int level, std::int64_t i, std::int64_t j) const {
    return slots_[0].find(relative(level).refinements, i, j);
  }
  /// The address of a point beyond one side of the face, in the face across that side. Returns
  /// nullptr if there is no such face, or if the point is not in it either.
  std::byte* beyond(int level, std::int64_t i, std::int64_t j) const {
    const std::int64_t size = this->size(level);
    const int side = size - i - j < 0 ? 0 : i < 0 ? 1 : 2;
    if (is_border(side)) return nullptr;
    const std::int64_t there_i = side == 1 ? -i : size - i, there_j = side == 2 ? -j : size - j;
    if (!contains(size, there_i, there_j)) return nullptr;
    return slots_[1 + static_cast<std::size_t>(side)].find(relative(level).refinements, there_i,
                                                           there_j);
  }
  /// Errors: kInvalidArgument unless has(level) and the point lies in the face, or so near to it
  /// that it can unfold into a neighbour.
  void check(int level, std::int64_t i, std::int64_t j) const;
  [[noreturn]] void refuse_beyond_border(int level, std::int64_t i, std::int64_t j) const;
  static bool contains(std::int64_t size, std::int64_t i, std::int64_t j) {
    return (i | j | (size - i - j)) >= 0;
  }

 private:
  FaceId face_ = kNoId;
  unsigned owned_ = 0, borders_ = 0;
  int base_level_ = 0;
  BaseRelativeLevel finest_;
  std::array<FaceSlots, 4> slots_;  ///< 0: of the face; 1 + x: of the face across side x
};

template <class Locate>
void PatchTable::enter(const Topology& mesh, FaceId face, std::size_t record_bytes,
                       bool with_neighbours, std::byte* base, Locate locate) {
  const int levels = finest_.refinements;
  face_ = face;
  owned_ = borders_ = 0;
  slots_[0].set_corners(mesh, face, 0, base, record_bytes);
  for (int side = 0; side < 3; ++side) {
    const EdgeId id = mesh.face_edges[face][static_cast<std::size_t>(side)];
    const Edge& edge = mesh.edges[id];
    const bool own = edge.own == FaceSide(face, side);
    owned_ |= unsigned{own} << side;
    borders_ |= unsigned{edge.is_border()} << side;
    FaceSlots& beyond = slots_[1 + static_cast<std::size_t>(side)];
    const bool open = with_neighbours && !edge.is_border();
    for (int level = 1; level <= levels; ++level) {
      const LocatedSlot slot = locate(id, BaseRelativeLevel(level));
      slots_[0].set(side, level, slot, own, record_bytes);
      if (open) beyond.set(side, level, slot, !own, record_bytes);
    }
    if (!open) continue;
    const FaceSide there = own ? edge.other : edge.own;
    beyond.set_corners(mesh, there.face(), there.side() + 3 - side, base, record_bytes);
    for (int turn = 1; turn <= 2; ++turn) {
      const FaceSide outer(there.face(), (there.side() + turn) % 3);
      const EdgeId outer_id = mesh.face_edges[outer.face()][static_cast<std::size_t>(outer.side())];
      for (int level = 1; level <= levels; ++level)
        beyond.set((side + turn) % 3, level, locate(outer_id, BaseRelativeLevel(level)),
                   mesh.edges[outer_id].own == outer, record_bytes);
    }
  }
}

/// The current patch of a mesh. The class Mesh has `table()`, `topology()` and a function
/// `anywhere(FaceIndex)`, which counts levels from the base mesh.
template <class Mesh>
class TabledPatch {
 public:
  using Record = typename Mesh::Record;

  explicit TabledPatch(Mesh& mesh) : mesh_(&mesh), table_(&mesh.table()) {}

  FaceId face() const { return table_->face(); }
  bool owns(int side) const { return table_->owns(side); }
  bool is_border(int side) const { return table_->is_border(side); }
  /// The number of steps along a side at `level`: the corners are (0, 0), (size, 0) and (0, size).
  /// REQUIRES: `level` is active, or the mesh's base level.
  std::int64_t size(int level) const { return table_->size(level); }

  /// The record at a point of the face's grid at `level`, or at a point beyond a side. Errors:
  /// kInvalidArgument for a level that is not active, and for a point that is not near the face, is
  /// out of the mesh's reach or lies beyond a border. Always inlined, because a call would cost as
  /// much as the look-up.
  [[gnu::always_inline]] Record& at(int level, std::int64_t i, std::int64_t j) const {
    if (table_->has(level) && PatchTable::contains(table_->size(level), i, j)) [[likely]]
      return *reinterpret_cast<Record*>(table_->inside(level, i, j));
    return beyond(level, i, j);
  }
  bool exists(int level, std::int64_t i, std::int64_t j) const {
    table_->check(level, i, j);
    return PatchTable::contains(size(level), i, j) || unfolded(level, i, j).face != kNoId;
  }

 private:
  [[gnu::noinline]] Record& beyond(int level, std::int64_t i, std::int64_t j) const {
    table_->check(level, i, j);
    if (std::byte* const address = table_->beyond(level, i, j))
      return *reinterpret_cast<Record*>(address);
    const FaceIndex there = unfolded(level, i, j);
    if (there.face == kNoId) table_->refuse_beyond_border(level, i, j);
    return mesh_->anywhere(there);
  }
  FaceIndex unfolded(int level, std::int64_t i, std::int64_t j) const {
    return unfold_fully(mesh_->topology(), {face(), table_->relative(level).refinements, i, j});
  }

  Mesh* mesh_;
  const PatchTable* table_;
};

PLAIT_END_NAMESPACE
