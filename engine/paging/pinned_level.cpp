#include "plait/detail/pinned_level.h"

#include <utility>

#include "paging/frame_pool.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

PinnedLevel::PinnedLevel(const LevelFile& file, LevelFile* written, Access access)
    : file_(&file),
      written_(written),
      access_(access),
      frame_bytes_(FramePool::frame_bytes(file.geometry.max_block_bytes())),
      starts_(file.geometry.block_count(), 0),
      blocks_(file.geometry.block_count()) {
  if (access != Access::kOverwrite && !file.traits.in_memory)
    announced_.assign(file.geometry.block_count(), false);
}

PinnedLevel::~PinnedLevel() {
  if (std::uncaught_exceptions() <= exceptions_) return;
  // The exception ends the walk in the middle of its work.
  if (written_) written_->left_unfinished = true;
  for (Pin& pin : pins_) pin.pinned.abandon();
}

void PinnedLevel::mark_needed(std::uint64_t block) {
  needed_.push_back(block);
  blocks_[block].needed_in = step_;
  if (starts_[block] != 0) pins_.splice(pins_.end(), pins_, blocks_[block].pin);
}

void PinnedLevel::need_edges_of(const PinnedLevel& other) {
  for (const std::uint64_t of_other : other.needed_) {
    const EdgeId first = other.geometry().first_edge(of_other);
    const EdgeId after = other.geometry().edge_after(of_other);
    for (std::uint64_t block = geometry().block_of(first);
         block < geometry().block_count() && geometry().first_edge(block) < after; ++block)
      need_block(block);
  }
}

BlockRequest PinnedLevel::request(std::uint64_t block) const {
  if (!written_) return {*file_, block};
  return {*written_, block, blocks_[block].was_pinned ? Access::kUpdate : access_};
}

void PinnedLevel::pin_needed(Session& session, std::span<PinnedLevel> levels) {
  std::vector<BlockRequest> requests;
  for (const PinnedLevel& level : levels)
    for (const std::uint64_t block : level.needed_)
      if (level.starts_[block] == 0) requests.push_back(level.request(block));
  if (requests.empty()) return;
  std::vector<PinnedBlock> pinned(requests.size());
  session.pin_many(requests, pinned);
  auto next = pinned.begin();
  for (PinnedLevel& level : levels)
    for (const std::uint64_t block : level.needed_) {
      if (level.starts_[block] != 0) continue;
      level.pins_.push_back({block, std::move(*next++)});
      const Pin& pin = level.pins_.back();
      level.blocks_[block].pin = --level.pins_.end();
      level.blocks_[block].was_pinned = true;
      level.starts_[block] = reinterpret_cast<std::uintptr_t>(pin.pinned.bytes().data()) -
                             level.geometry().block_offset(block);
    }
}

bool PinnedLevel::announce_block(Session& session, std::uint64_t block) noexcept {
  announced_[block] = session.prefetch(*file_, block);
  return announced_[block];
}

std::uint64_t PinnedLevel::missing_bytes() const noexcept {
  std::uint64_t bytes = 0;
  for (const std::uint64_t block : needed_) bytes += starts_[block] == 0 ? frame_bytes_ : 0;
  return bytes;
}

void PinnedLevel::release_block(std::uint64_t block) noexcept {
  starts_[block] = 0;
  pins_.erase(blocks_[block].pin);
}

PLAIT_END_NAMESPACE
