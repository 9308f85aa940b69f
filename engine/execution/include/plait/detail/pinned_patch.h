// plait/detail/pinned_patch.h: the blocks that the transparent executor pins while a program works
// on a patch.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "plait/detail/namespace.h"
#include "plait/detail/patch_table.h"
#include "plait/detail/pinned_level.h"
#include "plait/extend/store_access.h"
#include "plait/extend/sweep.h"
#include "plait/store.h"

PLAIT_BEGIN_NAMESPACE

/// Pins the blocks of the current face's stencil in one attribute. These are the blocks of the
/// face's edges; with Reach::kFaces also those of the faces across its sides; with Reach::kRing
/// also those of the faces around these. Blocks that earlier faces needed stay pinned while all
/// pins together fit into a share of the budget. The blocks that no face has needed for the longest
/// time are released first. For one thread.
class PinnedPatch {
 public:
  /// `share_bytes` is the share of the budget. The stencil of the current face is pinned even if it
  /// takes more.
  PinnedPatch(Store& store, AttributeId attribute, Reach reach, std::uint64_t share_bytes);
  /// An exception that ends the walk leaves what the program writes to unfinished.
  ~PinnedPatch();
  PinnedPatch(const PinnedPatch&) = delete;
  PinnedPatch& operator=(const PinnedPatch&) = delete;

  /// Chooses the levels that the program works on, and ends all pins. The program may read levels
  /// up to `readable`, and may also write levels `first_writable` to `last_writable` of these.
  /// Level numbers count from the user's mesh. The level of the base mesh is always active; a face
  /// has no grid at coarser levels. Errors: kInvalidArgument for levels that do not exist;
  /// kBadState for an unfinished level, and for writing to a store that was opened for reading;
  /// kBusy for writing while the store has readers or views.
  void activate(int readable, int first_writable, int last_writable);
  /// Tells that the program changes the base records too.
  void change_base_records();
  /// Makes `face` the current face. Errors: those of Session::pin_many.
  void enter(FaceId face);
  const PatchTable& table() const { return table_; }

  /// A slot of any edge. Errors: kInvalidArgument if its block is not pinned.
  LocatedSlot slot(BaseRelativeLevel level, EdgeId edge) const;

 private:
  void need(EdgeId edge) {
    for (PinnedLevel& level : levels_) level.need(edge);
  }
  void need_stencil(FaceId face);
  void make_room();

  Store* store_;
  AttributeId attribute_;
  Reach reach_;
  std::uint64_t share_bytes_;
  WrittenRecords* base_written_;
  Topology topology_;
  bool changes_base_records_ = false;
  int exceptions_;                 ///< that were under way when the walk began
  std::optional<StorePass> walk_;  ///< from the first activate() on
  Session session_;
  std::vector<PinnedLevel> levels_;  ///< [refinements of the base mesh - 1]
  PatchTable table_;
};

PLAIT_END_NAMESPACE
