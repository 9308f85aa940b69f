// Frames are had and given up.
#include <fmt/format.h>

#include <algorithm>

#include "paging/pager_implementation.h"
#include "plait/error.h"

namespace plait {

Frame* Pager::Implementation::take_frame(SessionState& session, const LevelFile& level,
                                         std::uint64_t block) {
  // What a mapping holds for a block never written is not known to be zeros.
  const bool addressed = level.traits.in_memory || (level.traits.maps_for_reading &&
                                                    !level.writable && was_written(level, block));
  Frame* const frame =
      table_.claim(level, block, addressed ? level.backend->address(block) : nullptr);
  if (frame) sessions_.give(*frame, &session);
  return frame;
}

bool Pager::Implementation::make_room(Lock& lock, SessionState& session, PinBatch& batch,
                                      const LevelFile& wanted_by) {
  const std::uint64_t wanted_bytes = FrameTable::frame_bytes(wanted_by);
  if (Frame* const clean = clean_victim(session, wanted_bytes)) {
    evict(lock, *clean);
    return true;
  }
  if (Frame* const dirty = sessions_.victim(session, wanted_bytes)) {
    write_here(lock, &session, *dirty);
    return true;
  }
  if (transfers_.writes() > 0) {
    wait_for_any(lock, &session, Direction::kWrite);
    return true;
  }
  if (Frame* const last = sessions_.last_announced(session, wanted_bytes)) {
    if (last->content.state == State::kDirty)
      write_here(lock, &session, *last);
    else
      evict(lock, *last);
    return true;
  }
  // From here on this call waits for others, who may wait for what it has taken.
  const std::uint64_t needed_bytes = batch.frame_bytes();
  let_go(batch);
  const bool fits = needed_bytes <= table_.pool().budget_bytes();
  if (!fits ||
      (transfers_.reads() == 0 && bringing_in_ == 0 && !sessions_.may_come_free(session))) {
    if (fits && transfers_.failed())
      transfers_.refuse(fmt::format("page in {}", batch[0].level->path.native()));
    refuse_room(needed_bytes, *batch[0].level);
  }
  const Sessions::Waiter waiter(sessions_, session);
  wait_for_any(lock, &session, Direction::kRead);
  return false;
}

void Pager::Implementation::refuse_room(std::uint64_t needed_bytes, const LevelFile& wanted_by) {
  std::uint64_t pinned_bytes = 0;
  for (const Frame& frame : table_.frames())
    if (frame.content.pins > 0 || frame.content.state == State::kStuck)
      pinned_bytes += frame.content.frame_bytes;
  const std::uint64_t budget = table_.pool().budget_bytes();
  throw Error(
      ErrorCode::kBudget,
      fmt::format("page in {}: at least {} bytes of frames are needed and {} of {} are available; "
                  "the others are pinned",
                  wanted_by.path.native(), needed_bytes, budget - std::min(pinned_bytes, budget),
                  budget));
}

Frame* Pager::Implementation::clean_victim(const SessionState& asking,
                                           std::uint64_t wanted_bytes) noexcept {
  Frame* const next = sessions_.victim(asking, wanted_bytes);
  return next && next->content.state == State::kClean ? next : nullptr;
}

void Pager::Implementation::evict(Lock& lock, Frame& frame) noexcept {
  ++statistics_.blocks_evicted;
  if (frame.content.session) ++frame.content.session->statistics.blocks_evicted;
  const bool mapped = frame.content.addressed && !frame.content.level->traits.in_memory;
  Backend& backend = *frame.transfer.backend;
  const std::uint64_t block = frame.content.block;
  drop(frame);
  if (!mapped) return;
  lock.unlock();
  backend.advise({block, 1}, Advice::kDontNeed);
  lock.lock();
}

void Pager::Implementation::hold(SessionState& session, Frame& frame) noexcept {
  sessions_.give(frame, &session);
  frame.to_write.unlink();
  ++frame.content.pins;
}

void Pager::Implementation::let_go(Frame& frame) noexcept {
  if (--frame.content.pins == 0) settle(frame);
}

void Pager::Implementation::settle(Frame& frame) noexcept {
  Frame::Content& content = frame.content;
  if (content.state == State::kClaimed || content.state == State::kDetached) return drop(frame);
  if (content.state == State::kDirty && transfers_.failed()) become(frame, State::kStuck);
  if (content.state == State::kDirty && content.level->traits.in_memory) write_in_memory(frame);
  if (content.state == State::kDirty && writes_behind(content.session))
    transfers_.queue_write(frame);
  else if (content.state == State::kClean || content.state == State::kDirty)
    sessions_.place(frame);
}

void Pager::Implementation::drop(Frame& frame) noexcept {
  frame.to_write.unlink();
  sessions_.give(frame, nullptr);
  drop_context(frame);
  table_.vacate(frame);
}

void Pager::Implementation::drop_context(Frame& frame) noexcept {
  for (std::size_t i = 0; i < frame.content.context_count; ++i) let_go(*frame.content.context[i]);
  frame.content.context_count = 0;
}

}  // namespace plait
