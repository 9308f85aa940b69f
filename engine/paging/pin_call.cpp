// The first half of a PinCall: it takes frames, and frees them again after an error.
#include "paging/pin_call.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <memory>
#include <utility>

#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Counts a call while the call runs. After its end there may be nothing left that the waiting
/// calls could wait for. So the end of a call wakes them, and they check again.
class Pager::Implementation::PinCall::UnderWay {
 public:
  explicit UnderWay(Implementation& pager) noexcept : pager_(pager) { ++pager_.calls_under_way_; }
  ~UnderWay() {
    --pager_.calls_under_way_;
    if (pager_.sessions_.anybody_waits()) pager_.wake_all();
  }
  UnderWay(const UnderWay&) = delete;
  UnderWay& operator=(const UnderWay&) = delete;

 private:
  Implementation& pager_;
};

void Pager::Implementation::PinCall::run(std::span<Frame*> frames) {
  const UnderWay under_way(pager_);
  check_may_write();
  try {
    while (!take_frames() || !read_blocks() || !fix_context()) {
      free_frames();
      check_may_write();
    }
  } catch (...) {
    free_frames();
    throw;
  }
  for (std::size_t at = 0; at < requests_.size(); ++at) {
    if (requests_[at].written()) add_writer(at);
    frames[at] = batch_[at].frame;
  }
  if (batch_.size() == requests_.size()) return;
  for (std::size_t at = requests_.size(); at < batch_.size(); ++at)
    pager_.remove_pin(*batch_[at].frame);
  pager_.transfers_.write_behind();
  pager_.wake_all();
}

void Pager::Implementation::PinCall::check_may_write() {
  for (const BlockRequest& request : requests_) {
    if (!request.written()) continue;
    check_not_fixed(request.level());
    if (pager_.transfers_.failed())
      pager_.transfers_.refuse(fmt::format("write {}", request.level().path.native()));
  }
}

bool Pager::Implementation::PinCall::fix_context() {
  check_may_write();
  for (std::size_t at = 0; at < requests_.size(); ++at)
    if (requests_[at].written()) fix_context_of(at);
  return !batch_.first([](const PinBatch::WantedBlock& entry) {
    return entry.frame->content.state == State::kDetached;
  });
}

void Pager::Implementation::PinCall::fix_context_of(std::size_t at) {
  const PinBatch::WantedBlock& entry = batch_[at];
  for (std::size_t i = 0; i < entry.context_count; ++i) {
    Frame& context = *batch_[entry.context + i].frame;
    Frame::Content& content = context.content;
    const LevelFile& level = *content.level;
    bool is_changed = content.writers > 0;
    for (std::size_t other = 0; other < requests_.size(); ++other)
      is_changed |= requests_[other].written() && batch_[other].frame == &context;
    if (is_changed)
      throw Error(
          ErrorCode::kBadState,
          fmt::format("write {}: block {} is encoded from block {} of {}, expected that "
                      "block to be complete; write coarser levels first",
                      entry.level->path.native(), entry.block, content.block, level.path.native()));
    level.is_fixed = true;
    if (content.state == State::kDirty) pager_.write_here(lock_, &session_, context);
    if (is_being_written(content.state))
      pager_.wait_while(lock_, session_, context, is_being_written);
  }
}

bool Pager::Implementation::PinCall::take_frames() {
  for (std::size_t at = 0; at < batch_.size(); ++at) {
    const LevelFile& level = *batch_[at].level;
    const std::uint64_t block = batch_[at].block;
    while (!batch_[at].frame) {
      if (Frame* const frame = pager_.table_.find(level, block)) {
        if (batch_[at].access != Access::kRead && is_being_written(frame->content.state)) {
          pager_.wait_while(lock_, session_, *frame, is_being_written);
          continue;
        }
        pager_.add_pin(session_, *frame, batch_[at].order);
        batch_[at].frame = frame;
      } else if (batch_[at].access == Access::kOverwrite && pager_.evict_written(lock_, session_) &&
                 pager_.table_.find(level, block)) {
        continue;  // another call took the block while the lock was released
      } else if (Frame* const taken = pager_.take_frame(session_, level, block)) {
        taken->pins.add(false);
        taken->content.order = batch_[at].order;
        taken->content.overwritten = batch_[at].access == Access::kOverwrite;
        batch_[at].frame = taken;
        batch_[at].brings_in = true;
      } else if (!make_room(level)) {
        return false;
      }
    }
    if (at >= batch_.request_count())
      keep_as_context(*batch_[at].frame, pager_.table_.needed_until(level, block));
    add_context(at);
  }
  return true;
}

void Pager::Implementation::PinCall::add_context(std::size_t at) {
  const PinBatch::WantedBlock entry = batch_[at];
  const LevelFile& level = *entry.level;
  if (level.traits.in_memory || entry.frame->content.context_count > 0) return;
  const bool is_read =
      entry.brings_in && entry.access != Access::kOverwrite && was_written(level, entry.block);
  if (!is_read && entry.access == Access::kRead) return;
  std::array<ContextBlock, kMostContextBlocks> needed;
  const std::size_t count = entry.access == Access::kRead
                                ? level.backend->read_context(entry.block, needed)
                                : level.backend->context(entry.block, needed);
  if (count > 0 && !entry.frame->context) entry.frame->context = std::make_unique<FrameContext>();
  for (const ContextBlock& context : std::span(needed).first(count)) {
    const LevelFile* const other = pager_.table_.level(context.attribute, context.level);
    if (!other || context.block >= other->geometry.block_count() || !comes_before(*other, level))
      throw Error(ErrorCode::kBadState,
                  fmt::format("page in {}: block {} needs block {} of level {} of attribute "
                              "{}, expected a block of an open level that comes earlier",
                              level.path.native(), entry.block, context.block, context.level,
                              context.attribute));
    batch_.add_context_of(at, *other, context.block);
  }
}

bool Pager::Implementation::PinCall::make_room(const LevelFile& wanted_by) {
  const std::uint64_t wanted_bytes = FrameTable::frame_bytes(wanted_by);
  if (Frame* const clean = pager_.clean_victim(session_, wanted_bytes)) {
    pager_.evict(lock_, *clean);
    return true;
  }
  if (Frame* const dirty = pager_.sessions_.victim(session_, wanted_bytes)) {
    pager_.write_here(lock_, &session_, *dirty);
    return true;
  }
  if (pager_.transfers_.writes() == 0 && pager_.transfers_.write_waiting())
    pager_.transfers_.write_behind();
  if (pager_.transfers_.writes() > 0) {
    pager_.wait_for_any(lock_, &session_, Direction::kWrite);
    return true;
  }
  if (Frame* const last = pager_.sessions_.last_announced(session_, wanted_bytes)) {
    if (last->content.state == State::kDirty)
      pager_.write_here(lock_, &session_, *last);
    else
      pager_.evict(lock_, *last);
    return true;
  }
  // This call must wait for other calls. These may wait for frames that this call has taken, so it
  // frees its frames first.
  const std::uint64_t needed_bytes = batch_.frame_bytes();
  free_frames();
  const Sessions::Waiter waiter(pager_.sessions_, session_);
  const bool fits = needed_bytes <= pager_.table_.pool().budget_bytes();
  if (!fits || (pager_.transfers_.reads() == 0 && pager_.calls_under_way_ == 1 &&
                !pager_.sessions_.may_come_free(session_))) {
    if (fits && pager_.transfers_.failed())
      pager_.transfers_.refuse(fmt::format("page in {}", batch_[0].level->path.native()));
    refuse_room(needed_bytes);
  }
  --pager_.calls_under_way_;
  pager_.wait_for_any(lock_, &session_, Direction::kRead);
  ++pager_.calls_under_way_;
  return false;
}

void Pager::Implementation::PinCall::refuse_room(std::uint64_t needed_bytes) {
  std::uint64_t pinned_bytes = 0;
  for (const Frame& frame : pager_.table_.frames())
    if (frame.pins.any() || frame.content.state == State::kStuck)
      pinned_bytes += frame.content.frame_bytes;
  const std::uint64_t budget = pager_.table_.pool().budget_bytes();
  throw Error(
      ErrorCode::kBudget,
      fmt::format("page in {}: at least {} bytes of frames are needed and {} of {} are available; "
                  "{}",
                  batch_[0].level->path.native(), needed_bytes,
                  budget - std::min(pinned_bytes, budget), budget,
                  needed_bytes > budget
                      ? fmt::format("raise the budget to {} bytes",
                                    pager_.table_.pool().needed_budget(needed_bytes))
                      : "the others are pinned: end pins or views, or raise the budget"));
}

void Pager::Implementation::PinCall::add_writer(std::size_t at) noexcept {
  const PinBatch::WantedBlock& entry = batch_[at];
  Frame::Content& content = entry.frame->content;
#ifndef NDEBUG
  if (content.state == State::kClaimed && !content.addressed)
    std::memset(content.memory, 0xcd, content.block_bytes);
#endif
  pager_.add_writer(*entry.frame);
  if (content.context_count == 0) pin_context(entry);
}

void Pager::Implementation::PinCall::pin_context(const PinBatch::WantedBlock& entry) noexcept {
  Frame& frame = *entry.frame;
  for (std::size_t i = 0; i < entry.context_count; ++i) {
    Frame* const other = batch_[entry.context + i].frame;
    other->pins.add(false);
    frame.context->blocks[i] = other;
  }
  frame.content.context_count = entry.context_count;
}

void Pager::Implementation::PinCall::free_frames() noexcept {
  for (PinBatch::WantedBlock& entry : batch_) {
    Frame* const frame = std::exchange(entry.frame, nullptr);
    if (!frame) continue;
    // Calls that wait for the block then find it absent, and read it themselves.
    if (entry.brings_in && frame->content.state == State::kClaimed && frame->pins.count() > 1)
      pager_.table_.detach_block(*frame);
    entry.brings_in = false;
    pager_.remove_pin(*frame);
  }
  batch_.forget_context();
  pager_.transfers_.write_behind();
  pager_.wake_all();
}

PLAIT_END_NAMESPACE
