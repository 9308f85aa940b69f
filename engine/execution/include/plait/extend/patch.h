// plait/extend/patch.h: the transparent executor. A program loops over patches and levels itself
// and reaches vertices by at(level, i, j). The store decides which blocks are in memory (Guskov's
// paper, section 4).
//
// The same source runs over StorePatches and over InCoreMesh (plait/extend/in_core_mesh.h); the
// concept PatchMesh lists the functions that such a source may use.
#pragma once

#include <concepts>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>

#include "plait/detail/namespace.h"
#include "plait/detail/patch_table.h"
#include "plait/detail/pinned_patch.h"
#include "plait/extend/edge_index.h"
#include "plait/store.h"

PLAIT_BEGIN_NAMESPACE

/// The functions that a program written for patches may use. A patch is a face of the base mesh and
/// its refined grid. The base mesh has a level itself (Store::base_level() for a store, which is 0
/// unless the store was rebased). At that level and at finer ones a patch is a grid with corners
/// (0, 0), (size(level), 0) and (0, size(level)). `at` takes a point of this grid, or a point
/// beyond a side that unfolds into a neighbouring face. References stay valid while the patch is
/// the mesh's current patch. `exists` returns false for a point beyond a border.
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

/// One attribute of a store as a PatchMesh. Its patches are the faces of Store::base(). For one
/// thread.
template <class RecordType>
class StorePatches {
 public:
  using Record = RecordType;

  using Patch = TabledPatch<StorePatches>;

  /// See PinnedPatch. Errors: kInvalidArgument if the attribute holds other records.
  StorePatches(Store& store, AttributeId attribute, std::uint64_t share_bytes,
               Reach reach = Reach::kFaces)
      : store_(&store),
        attribute_(attribute),
        base_records_(std::as_const(store).template base_records<Record>(attribute)),
        pinned_(std::make_unique<PinnedPatch>(store, attribute, reach, share_bytes)),
        topology_(store.base().topology()) {}

  const Topology& topology() const { return topology_; }
  /// To be changed. Errors: kBadState if the store was opened for reading.
  std::span<Record> base_records() const {
    pinned_->change_base_records();
    return store_->base_records<Record>(attribute_);
  }
  /// See PinnedPatch::activate.
  void activate(int readable, int first_writable, int last_writable) {
    pinned_->activate(readable, first_writable, last_writable);
  }
  /// Makes `face` the current patch. The previous patch must not be used any more.
  Patch patch(FaceId face) {
    pinned_->enter(face);
    return Patch(*this);
  }

 private:
  friend Patch;

  const PatchTable& table() const { return pinned_->table(); }
  /// The record at a point of any face whose blocks are pinned.
  Record& anywhere(const FaceIndex& point) {
    if (is_corner(point.level, point.i, point.j))
      return const_cast<Record&>(base_records_[topology_.faces[point.face][static_cast<std::size_t>(
          corner_of(point.i, point.j))]]);
    const EdgeIndex index = edge_index(topology_, point);
    const LocatedSlot slot = pinned_->slot(BaseRelativeLevel(index.level), index.edge);
    return slot.of<Record>().at(index.level, index.row, index.column);
  }

  Store* store_;
  AttributeId attribute_;
  std::span<const Record> base_records_;
  std::unique_ptr<PinnedPatch> pinned_;
  Topology topology_;
};

PLAIT_END_NAMESPACE
