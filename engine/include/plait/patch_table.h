// plait/patch_table.h: where the records of one base face, and of the faces across its sides, lie:
// looked up once when the face is entered, so that at(level, i, j) is a few instructions.
//
// A face at a level is a grid with corners (0, 0), (size, 0) and (0, size), size = 2^k, where k
// counts how often the base mesh is refined to reach that level. Levels themselves are the user's
// numbers.
//
// Reduce (i, j) by its trailing zeros to the level of birth, where k1 = i >> s, k2 = j >> s; their
// low bits tell the side (see plait/edge_index.h). With a = k1 >> 1, b = k2 >> 1 and n = 2^(l-1),
// the slot's coordinates are linear in (a, b) on every side:
//
//   bits k1 k2   side        row           column
//        1  1    0 (bc)      a             b
//        0  1    1 (ca)      b             n-1 - a-b
//        1  0    2 (ab)      n-1 - a-b     a
//
// From the edge's other face both count backwards. So an origin and two steps address a whole slot.
// A half slot is stored in the frame of the one face that has it, and is a triangle whose rows
// shrink: from its address, row (row - 1) / 2 records are subtracted. Corners come out at level 0
// with a = b = 0, and their bits tell which corner it is, so corners need no branch.
//
// The table keeps a face across side x as if that face were turned so that the common edge is its
// side x too. A point beyond side x then has the weights size - k(x+1), size - k(x+2) and -k(x)
// there.
// Pinned by tests/engine/execution/patch_test.cpp.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "plait/base_relative_level.h"
#include "plait/edge_index.h"
#include "plait/slot_shapes.h"
#include "plait/topology.h"

namespace plait {

/// One thread. Addresses are valid as long as the caller keeps them so.
class PatchTable {
 public:
  FaceId face() const { return face_; }
  bool owns(int side) const { return (owned_ >> side & 1) != 0; }
  bool is_border(int side) const { return (borders_ >> side & 1) != 0; }

  /// The levels that are entered: that of the base mesh, and so many more.
  void set_levels(int base_level, BaseRelativeLevel finest) {
    base_level_ = base_level;
    finest_ = finest;
  }
  /// Whether `level` is one of them.
  [[gnu::always_inline]] bool has(int level) const {
    return static_cast<unsigned>(level - base_level_) <= static_cast<unsigned>(finest_.refinements);
  }
  /// REQUIRES: has(level), here and below.
  [[gnu::always_inline]] BaseRelativeLevel relative(int level) const {
    return relative_to_base(level, base_level_);
  }
  [[gnu::always_inline]] std::int64_t size(int level) const {
    return std::int64_t{1} << relative(level).refinements;
  }

  /// Makes `face` current. `base` is where the base vertices' records are. The table calls
  /// `locate(edge, BaseRelativeLevel)`, which gives a LocatedSlot, once per edge and level.
  /// `with_neighbours` adds the faces across the sides.
  template <class Locate>
  void enter(const Topology& mesh, FaceId face, std::size_t record_bytes, bool with_neighbours,
             std::byte* base, Locate locate);

  /// Address of a point of the face. REQUIRES: it is in the face.
  [[gnu::always_inline]] std::byte* inside(int level, std::int64_t i, std::int64_t j) const {
    return find(0, relative(level).refinements, i, j);
  }
  /// Address of a point beyond one side of the face, in the face there; nullptr if it is none of
  /// that face either, or there is no such face.
  std::byte* beyond(int level, std::int64_t i, std::int64_t j) const {
    const std::int64_t size = this->size(level);
    const int side = size - i - j < 0 ? 0 : i < 0 ? 1 : 2;
    if (is_border(side)) return nullptr;
    const std::int64_t there_i = side == 1 ? -i : size - i, there_j = side == 2 ? -j : size - j;
    if (!contains(size, there_i, there_j)) return nullptr;
    return find(1 + static_cast<std::size_t>(side), relative(level).refinements, there_i, there_j);
  }
  /// Errors: kInvalidArgument unless has(level), and the point lies in the face or so near it that
  /// it may unfold into a neighbour.
  void check(int level, std::int64_t i, std::int64_t j) const;
  [[noreturn]] void refuse_beyond_border(int level, std::int64_t i, std::int64_t j) const;
  static bool contains(std::int64_t size, std::int64_t i, std::int64_t j) {
    return (i | j | (size - i - j)) >= 0;
  }

 private:
  /// How the coordinates a, b of a point become an address.
  struct SlotSteps {
    std::byte* origin = nullptr;
    std::int64_t a_step = 0, b_step = 0;  ///< bytes
    std::int64_t triangle_step = 0;       ///< bytes of a record in a half slot, else 0
  };

  /// `level` counts refinements of the base mesh, as steps_ does.
  [[gnu::always_inline]] std::byte* find(std::size_t which, int level, std::int64_t i,
                                         std::int64_t j) const {
    const int shift =
        std::countr_zero(static_cast<std::uint64_t>(i | j | std::int64_t{1} << level));
    const std::int64_t k1 = i >> shift, k2 = j >> shift;
    const auto bits = static_cast<std::size_t>((k1 & 1) | (k2 & 1) << 1);
    const SlotSteps& steps = steps_[which][static_cast<std::size_t>(level - shift)][bits];
    const std::int64_t a = k1 >> 1, b = k2 >> 1;
    std::byte* const address = steps.origin + (a * steps.a_step + b * steps.b_step);
    if (steps.triangle_step == 0) [[likely]]
      return address;
    const std::int64_t n = slot_side(level - shift);
    const std::int64_t row = bits == 3 ? a : bits == 2 ? b : n - 1 - a - b;
    return address - row * (row - 1) / 2 * steps.triangle_step;
  }

  /// The steps of side `side` at `level`. `own`: the face is its edge's own.
  void set(std::size_t which, int side, int level, const LocatedSlot& slot, bool own) {
    const bool half = slot.shape == SlotShape::kHalf, forwards = own || half;
    const std::int64_t n = slot_side(level), record = forwards ? record_bytes_ : -record_bytes_;
    std::byte* const first = slot.bytes.data() + (forwards ? 0 : (n * n - 1) * record_bytes_);
    const std::int64_t triangle_step = half ? record_bytes_ : 0;
    auto& steps = steps_[which][static_cast<std::size_t>(level)];
    switch (side) {
      case 0:
        steps[3] = {first, n * record, record, triangle_step};
        break;
      case 1:
        steps[2] = {first + (n - 1) * record, -record, (n - 1) * record, triangle_step};
        break;
      default:
        steps[1] = {first + (n - 1) * n * record, (1 - n) * record, -n * record, triangle_step};
    }
  }
  void set_corners(const Topology& mesh, std::size_t which, FaceId face, int turn,
                   std::byte* base) {
    for (int corner = 0; corner < 3; ++corner) {
      const VertexId vertex = mesh.faces[face][static_cast<std::size_t>((corner + turn) % 3)];
      steps_[which][0][static_cast<std::size_t>(corner)] = {base + vertex * record_bytes_};
    }
  }

  FaceId face_ = kNoId;
  unsigned owned_ = 0, borders_ = 0;
  std::int64_t record_bytes_ = 0;
  int base_level_ = 0;
  BaseRelativeLevel finest_;
  /// [the face, or 1 + the side that another lies across][refinements][low bits of k1, k2]
  std::array<std::array<std::array<SlotSteps, 4>, kMaxLevel + 1>, 4> steps_{};
};

template <class Locate>
void PatchTable::enter(const Topology& mesh, FaceId face, std::size_t record_bytes,
                       bool with_neighbours, std::byte* base, Locate locate) {
  const int levels = finest_.refinements;
  face_ = face;
  owned_ = borders_ = 0;
  record_bytes_ = static_cast<std::int64_t>(record_bytes);
  set_corners(mesh, 0, face, 0, base);
  for (int side = 0; side < 3; ++side) {
    const EdgeId id = mesh.face_edges[face][static_cast<std::size_t>(side)];
    const Edge& edge = mesh.edges[id];
    const bool own = edge.own == FaceSide(face, side);
    owned_ |= unsigned{own} << side;
    borders_ |= unsigned{edge.is_border()} << side;
    const auto which = 1 + static_cast<std::size_t>(side);
    const bool open = with_neighbours && !edge.is_border();
    for (int level = 1; level <= levels; ++level) {
      const LocatedSlot slot = locate(id, BaseRelativeLevel(level));
      set(0, side, level, slot, own);
      if (open) set(which, side, level, slot, !own);
    }
    if (!open) continue;
    const FaceSide there = own ? edge.other : edge.own;
    set_corners(mesh, which, there.face(), there.side() + 3 - side, base);
    for (int turn = 1; turn <= 2; ++turn) {
      const FaceSide outer(there.face(), (there.side() + turn) % 3);
      const EdgeId outer_id = mesh.face_edges[outer.face()][static_cast<std::size_t>(outer.side())];
      for (int level = 1; level <= levels; ++level)
        set(which, (side + turn) % 3, level, locate(outer_id, BaseRelativeLevel(level)),
            mesh.edges[outer_id].own == outer);
    }
  }
}

/// The current patch of a mesh that has `table()`, `topology()` and, for this class, a function
/// `anywhere(FaceIndex)`, whose points count levels from the base mesh.
template <class Mesh>
class TabledPatch {
 public:
  using Record = typename Mesh::Record;

  explicit TabledPatch(Mesh& mesh) : mesh_(&mesh), table_(&mesh.table()) {}

  FaceId face() const { return table_->face(); }
  bool owns(int side) const { return table_->owns(side); }
  bool is_border(int side) const { return table_->is_border(side); }
  /// Steps along a side at `level`: the corners are (0, 0), (size, 0) and (0, size).
  /// REQUIRES: `level` is active, or the mesh's base level.
  std::int64_t size(int level) const { return table_->size(level); }

  /// The record at a point of the face's grid at `level`, or beyond a side.
  /// Errors: kInvalidArgument for a level that is not active, and for a point that is not near the
  /// face, or out of the mesh's reach or beyond a border. Inlined whatever the compiler thinks of
  /// its size: a call costs as much as the look-up.
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

}  // namespace plait
