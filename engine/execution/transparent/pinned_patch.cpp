#include "plait/detail/pinned_patch.h"

#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <utility>

#include "plait/error.h"
#include "plait/extend/store_access.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

PinnedPatch::PinnedPatch(Store& store, AttributeId attribute, Reach reach,
                         std::uint64_t share_bytes)
    : store_(&store),
      attribute_(attribute),
      reach_(reach),
      share_bytes_(share_bytes),
      base_written_(&StoreAccess::base_records_of(store, attribute)),
      topology_(store.base().topology()),
      exceptions_(std::uncaught_exceptions()) {}

PinnedPatch::~PinnedPatch() {
  if (!changes_base_records_ || std::uncaught_exceptions() <= exceptions_) return;
  base_written_->left_unfinished = true;
}

void PinnedPatch::change_base_records() {
  if (!walk_) walk_.emplace(*store_, StorePass::Kind::kWalk);
  changes_base_records_ = true;
}

void PinnedPatch::activate(int readable, int first_writable, int last_writable) {
  const int base_level = store_->base_level();
  const AttributeInfo& info = store_->attributes()[attribute_];
  if (readable < base_level || readable > info.finest_level)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("activate level {} of '{}': expected {} to {}", readable,
                            info.schema.name, base_level, info.finest_level));
  StoreAccess::refuse_depths(*store_, "walk over the patches of", readable);
  changes_base_records_ =
      changes_base_records_ || first_writable <= std::min(base_level, last_writable);
  if (changes_base_records_) StoreAccess::lend_base_records(*store_, attribute_);
  const auto access = [&](int level) {
    return level >= first_writable && level <= last_writable ? Access::kUpdate : Access::kRead;
  };
  for (int level = base_level + 1; level <= readable; ++level)
    StoreAccess::check_readable(*store_, attribute_, level, true);
  if (const int first = std::max(first_writable, base_level + 1);
      first <= std::min(last_writable, readable))
    const StorePass allowed(
        *store_, fmt::format("activate level {} of '{}' for writing in", first, info.schema.name));
  if (!walk_) walk_.emplace(*store_, StorePass::Kind::kWalk);
  levels_.clear();
  for (int level = base_level + 1; level <= readable; ++level)
    levels_.emplace_back(StoreAccess::level_file(*store_, attribute_, level), access(level));
  table_.set_levels(base_level, relative_to_base(readable, base_level));
  session_ = StoreAccess::open_session(*store_);
}

void PinnedPatch::need_stencil(FaceId face) {
  for (const EdgeId edge : topology_.face_edges[face]) need(edge);
  for (int side = 0; side < 3 && reach_ != Reach::kOwn; ++side) {
    const FaceSide beyond = topology_.across(FaceSide(face, side));
    if (!beyond.exists()) continue;
    for (int turn = 1; turn <= 2; ++turn) {
      const FaceSide outer(beyond.face(), (beyond.side() + turn) % 3);
      need(topology_.face_edges[outer.face()][static_cast<std::size_t>(outer.side())]);
      const FaceSide further = reach_ == Reach::kRing ? topology_.across(outer) : FaceSide();
      if (!further.exists()) continue;
      for (const EdgeId edge : topology_.face_edges[further.face()]) need(edge);
    }
  }
}

void PinnedPatch::make_room() {
  std::uint64_t bytes = 0, missing = 0;
  for (const PinnedLevel& level : levels_) {
    bytes += level.pinned_bytes();
    missing += level.missing_bytes();
  }
  while (missing != 0 && bytes + missing > share_bytes_) {
    PinnedLevel* oldest = nullptr;
    for (PinnedLevel& level : levels_)
      if (level.has_rest() && (!oldest || level.oldest_step() < oldest->oldest_step()))
        oldest = &level;
    if (!oldest) return;
    oldest->release_oldest();
    bytes -= oldest->frame_bytes();
  }
}

void PinnedPatch::enter(FaceId face) {
  for (PinnedLevel& level : levels_) level.begin_step();
  need_stencil(face);
  make_room();
  PinnedLevel::pin_needed(session_, levels_);
  // A store that was opened for reading gives out only const records. Programs write to none of the
  // addresses, unless they have activated levels for writing.
  auto* const base = const_cast<std::byte*>(std::as_const(*store_).base_bytes(attribute_).data());
  table_.enter(topology_, face, store_->attributes()[attribute_].schema.record_bytes(),
               reach_ != Reach::kOwn, base, [&](EdgeId edge, BaseRelativeLevel level) {
                 return levels_[static_cast<std::size_t>(level.refinements - 1)].slot(edge);
               });
}

LocatedSlot PinnedPatch::slot(BaseRelativeLevel level, EdgeId edge) const {
  const PinnedLevel& at = levels_[static_cast<std::size_t>(level.refinements - 1)];
  if (!at.is_pinned(edge))
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("face {} of '{}': the point is beyond the reach of the patch",
                            table_.face(), store_->attributes()[attribute_].schema.name));
  return at.slot(edge);
}

PLAIT_END_NAMESPACE
