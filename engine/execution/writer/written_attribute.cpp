#include "execution/writer/written_attribute.h"

#include <algorithm>

#include "plait/extend/base_relative_level.h"
#include "plait/extend/store_access.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

WrittenAttribute::WrittenAttribute(Store& store, AttributeId id, int first, int last)
    : schema_(store.attributes()[id].schema),
      mesh_(store.base().topology()),
      first_(first),
      last_(last),
      coarsest_(std::max(first, 1)),
      base_(first == 0 ? StoreAccess::base_bytes(store, id, Access::kOverwrite)
                       : std::span<std::byte>()),
      base_written_(&StoreAccess::base_records_of(store, id)) {
  const std::size_t faces = mesh_.faces.size();
  for (int level = first; level <= last; ++level)
    faces_.push_back({std::vector<bool>(faces, false), faces});
  held_.reserve(static_cast<std::size_t>(std::max(last - coarsest_ + 1, 0)));
  for (int level = coarsest_; level <= last; ++level) {
    LevelFile& file = StoreAccess::level_file(
        store, id, level_number(BaseRelativeLevel(level), store.base_level()));
    const LevelGeometry& geometry = file.geometry;
    const std::size_t blocks = geometry.block_count();
    blocks_.push_back(
        {&file, std::vector<std::uint32_t>(blocks), std::vector<std::uint32_t>(blocks)});
    Blocks& of_level = blocks_.back();
    for (EdgeId edge = 0; edge < mesh_.edges.size(); ++edge) {
      const SlotShape shape = geometry.slot(edge).shape;
      if (shape != SlotShape::kAbsent)
        of_level.to_fill[geometry.block_of(edge)] += shape == SlotShape::kHalf ? 1 : 2;
    }
    // A block that leaves memory before it is full holds, where nothing is written yet, what was in
    // its frame. Not every pipeline encodes any bytes, but all encode zeros.
    held_.emplace_back(file, file.traits.compressed ? Access::kUpdate : Access::kOverwrite);
  }
}

std::uint64_t WrittenAttribute::need(FaceId face, int from, int to, FilledBlocks& blocks) {
  std::uint64_t missing = 0;
  blocks.clear();
  for (int level = std::max(from, coarsest_); level <= to; ++level) {
    const std::size_t place = place_of(level), first = blocks.size();
    PinnedLevel& held = held_[place];
    for (const EdgeId edge : mesh_.face_edges[face]) {
      const std::uint64_t block = held.geometry().block_of(edge);
      const auto listed =
          std::find_if(blocks.begin() + static_cast<std::ptrdiff_t>(first), blocks.end(),
                       [&](const FilledBlock& other) { return other.block == block; });
      if (listed != blocks.end()) {
        ++listed->slots;
        continue;
      }
      blocks.push_back({static_cast<std::uint32_t>(place), 1, block});
      held.need_block(block);
      if (!held.is_block_pinned(block)) missing += held.frame_bytes();
    }
  }
  return missing;
}

void WrittenAttribute::use(Session& session, const FilledBlocks& blocks) {
  PinnedLevel::pin_needed(session, held_);
  for (const FilledBlock& each : blocks) ++blocks_[each.place].users[each.block];
}

void WrittenAttribute::end_use(const FilledBlocks& blocks) noexcept {
  for (const FilledBlock& each : blocks) {
    Blocks& level = blocks_[each.place];
    if (--level.users[each.block] == 0 && level.to_fill[each.block] == 0 &&
        held_[each.place].is_block_pinned(each.block))
      held_[each.place].release_block(each.block);
  }
}

void WrittenAttribute::note_written(FaceId face, int from, int to,
                                    const FilledBlocks& blocks) noexcept {
  auto next = blocks.begin();
  for (int level = from; level <= to; ++level) {
    Faces& faces = faces_[static_cast<std::size_t>(level - first_)];
    const bool is_new = !faces.written[face];
    if (is_new) {
      faces.written[face] = true;
      --faces.missing;
    }
    if (level < coarsest_) continue;
    for (; next != blocks.end() && next->place == place_of(level); ++next)
      if (is_new) blocks_[next->place].to_fill[next->block] -= next->slots;
  }
}

PinnedLevel* WrittenAttribute::oldest_idle() noexcept {
  PinnedLevel* oldest = nullptr;
  for (std::size_t at = 0; at < held_.size(); ++at) {
    PinnedLevel& level = held_[at];
    if (level.has_rest() && blocks_[at].users[level.oldest_block()] == 0 &&
        (!oldest || level.oldest_step() < oldest->oldest_step()))
      oldest = &level;
  }
  return oldest;
}

void WrittenAttribute::release_all() noexcept {
  for (PinnedLevel& level : held_) {
    level.begin_step();
    level.release_rest();
  }
}

FaceSlots WrittenAttribute::slots(FaceId face, int from, int to) const {
  FaceSlots slots;
  const std::size_t record_bytes = schema_.record_bytes();
  if (!base_.empty()) slots.set_corners(mesh_, face, 0, base_.data(), record_bytes);
  for (int level = std::max(from, coarsest_); level <= to; ++level)
    for (int side = 0; side < 3; ++side)
      slots.set(side, level,
                held_[place_of(level)].slot(mesh_.face_edges[face][static_cast<std::size_t>(side)]),
                mesh_.is_own(face, side), record_bytes);
  return slots;
}

FaceId WrittenAttribute::first_missing(int level) const {
  const std::vector<bool>& written = faces_at(level).written;
  return static_cast<FaceId>(std::ranges::find(written, false) - written.begin());
}

PLAIT_END_NAMESPACE
