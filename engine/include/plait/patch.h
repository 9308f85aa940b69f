// plait/patch.h: the transparent executor: a program's own loops over patches, coarse to fine,
// with at(level, i, j), while the store decides what is in memory (Guskov's paper, section 4).
//
// The same source runs over StorePatches and over InCoreMesh (plait/in_core_mesh.h); the concept
// PatchMesh says what it may rely on.
#pragma once

#include <concepts>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "plait/edge_index.h"
#include "plait/patch_table.h"
#include "plait/store.h"
#include "plait/sweep.h"

namespace plait {

/// What a program written for patches may use. A patch is a face of the mesh's base mesh, which is
/// at some level itself (of a store: Store::base_level(), 0 unless it was rebased); at that level
/// and finer ones a patch is a grid with corners (0, 0), (size(level), 0) and (0, size(level)).
/// `at` takes any point of it, and points beyond a side that unfold into a face there; references
/// stay valid while the patch is the mesh's current one. `exists` tells whether a border cuts such
/// a point off.
template <class Mesh>
concept PatchMesh = requires(Mesh mesh, FaceId face, int level, std::int64_t i, int side) {
  typename Mesh::Record;
  { mesh.topology() } -> std::convertible_to<Topology>;
  { mesh.base_records() } -> std::convertible_to<std::span<typename Mesh::Record>>;
  mesh.activate(level, level, level);
  { mesh.patch(face).at(level, i, i) } -> std::same_as<typename Mesh::Record&>;
  { mesh.patch(face).size(level) } -> std::convertible_to<std::int64_t>;
  { mesh.patch(face).owns(side) } -> std::convertible_to<bool>;
  { mesh.patch(face).is_border(side) } -> std::convertible_to<bool>;
  { mesh.patch(face).exists(level, i, i) } -> std::convertible_to<bool>;
};

/// Type-free half of StorePatches: pins the blocks of the current face's stencil (its edges and
/// those of the faces across them; with Reach::kRing also of the faces around these) and keeps
/// older ones pinned up to a share of the budget.
class PatchWindow {
 public:
  PatchWindow(Store& store, AttributeId attribute, Reach reach, std::uint64_t window_bytes);
  ~PatchWindow();
  PatchWindow(const PatchWindow&) = delete;
  PatchWindow& operator=(const PatchWindow&) = delete;

  /// Levels up to `readable` may be read; of these, levels `first_writable` to `last_writable` may
  /// also be written. Levels number as everywhere in a store, from the mesh that the user gave;
  /// that of the base mesh is always active, and those before it are in no grid of a face. Ends all
  /// pins. Errors: kInvalidArgument for levels that are not there, kBadState.
  void activate(int readable, int first_writable, int last_writable);
  /// Makes `face` current. Errors: kBudget, and those of Session::pin.
  void enter(FaceId face);
  const PatchTable& table() const { return table_; }

 private:
  template <class Record>
  friend class StorePatches;
  struct Pins;
  struct Level {
    LevelFile* file = nullptr;
    /// [block] address that the level's first byte would have if all of it lay where the block
    /// does; 0 while the block is not pinned.
    std::vector<std::uintptr_t> starts;
  };

  /// Address of a slot. Errors: kInvalidArgument if its block is not pinned.
  std::byte* pinned_slot(BaseRelativeLevel level, EdgeId edge) const;
  /// REQUIRES: its block is pinned.
  std::byte* slot(BaseRelativeLevel level, EdgeId edge, std::uint64_t rank) const {
    const Level& at = levels_[static_cast<std::size_t>(level.refinements)];
    const LevelGeometry& geometry = at.file->geometry;
    return reinterpret_cast<std::byte*>(at.starts[geometry.block_of(edge)] +
                                        geometry.slot_offset(edge, rank));
  }
  void need(EdgeId edge);

  Store* store_;
  AttributeId attribute_;
  Reach reach_;
  Topology topology_;
  std::size_t record_bytes_;
  std::vector<Level> levels_;  ///< [refinements of the base mesh]
  std::unique_ptr<Pins> pins_;
  PatchTable table_;
};

/// One attribute of a store as a PatchMesh: its patches are the faces of Store::base(). One thread.
template <class RecordType>
class StorePatches {
 public:
  using Record = RecordType;

  using Patch = TabledPatch<StorePatches>;

  /// `window_bytes` is the share of the store's budget to keep pinned; a face's own blocks are
  /// pinned in any case. Errors: kInvalidArgument if the attribute holds other records.
  StorePatches(Store& store, AttributeId attribute, std::uint64_t window_bytes,
               Reach reach = Reach::kFaces)
      : base_records_(store.base_records<Record>(attribute)),
        window_(std::make_unique<PatchWindow>(store, attribute, reach, window_bytes)),
        topology_(store.base().topology()) {}

  const Topology& topology() const { return topology_; }
  std::span<Record> base_records() const { return base_records_; }
  /// See PatchWindow::activate.
  void activate(int readable, int first_writable, int last_writable) {
    window_->activate(readable, first_writable, last_writable);
  }
  /// Makes `face` the current patch; the one before it must not be used any more.
  Patch patch(FaceId face) {
    window_->enter(face);
    return Patch(*this);
  }

 private:
  friend Patch;

  const PatchTable& table() const { return window_->table(); }
  /// The record at a point of any face whose blocks are pinned.
  Record& anywhere(const FaceIndex& point) {
    if (is_corner(point.level, point.i, point.j))
      return base_records_[topology_.faces[point.face]
                                          [static_cast<std::size_t>(corner_of(point.i, point.j))]];
    const EdgeIndex index = edge_index(topology_, point);
    const bool border = topology_.edges[index.edge].is_border();
    return reinterpret_cast<Record*>(window_->pinned_slot(
        BaseRelativeLevel(index.level),
        index.edge))[slot_position(index.level, border, index.row, index.column)];
  }

  std::span<Record> base_records_;
  std::unique_ptr<PatchWindow> window_;
  Topology topology_;
};

}  // namespace plait
