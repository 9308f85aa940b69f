// plait/pinned_patch.h: what the transparent executor has pinned while a program works at a patch.
#pragma once

#include <cstdint>
#include <vector>

#include "plait/patch_table.h"
#include "plait/pinned_level.h"
#include "plait/store.h"
#include "plait/sweep.h"

namespace plait {

/// Pins the blocks of the current face's stencil in one attribute: those of its edges, with
/// Reach::kFaces also of the faces across them, with Reach::kRing also of the faces around these.
/// Blocks that earlier faces needed stay pinned as long as all pins together fit into a share of
/// the budget; those whose need lies furthest back are released first. One thread.
class PinnedPatch {
 public:
  /// `share_bytes` is that share. A face's own stencil is pinned even if it takes more.
  PinnedPatch(Store& store, AttributeId attribute, Reach reach, std::uint64_t share_bytes);
  PinnedPatch(const PinnedPatch&) = delete;
  PinnedPatch& operator=(const PinnedPatch&) = delete;

  /// Levels up to `readable` may be read; of these, levels `first_writable` to `last_writable` may
  /// also be written. Level numbers count from the mesh that the user gave. The level of the base
  /// mesh is always active; a face has no grid of levels before it. Ends all pins.
  /// Errors: kInvalidArgument for levels that are not there; kBadState for writing to a store that
  /// was opened for reading.
  void activate(int readable, int first_writable, int last_writable);
  /// Makes `face` current. Errors: kBudget, and those of Session::pin_many.
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
  Topology topology_;
  Session session_;
  std::vector<PinnedLevel> levels_;  ///< [refinements of the base mesh - 1]
  PatchTable table_;
};

}  // namespace plait
