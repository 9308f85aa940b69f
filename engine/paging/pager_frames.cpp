#include <fmt/format.h>

#include <algorithm>
#include <new>
#include <utility>

#include "paging/pager_implementation.h"
#include "plait/error.h"

namespace plait {

Frame* Pager::Implementation::claim(Lock& lock, SessionState& session, const LevelFile& level,
                                    std::uint64_t block) {
  const std::uint64_t frame_bytes = FramePool::frame_bytes(level.geometry.max_block_bytes());
  try {
    Frame* frame = nullptr;
    while (!(frame = take_frame(session, level, block)))
      if (!make_room(lock, session, level, frame_bytes)) return nullptr;
    ++frame->content.pins;
    return frame;
  } catch (const std::bad_alloc&) {
    throw Error(ErrorCode::kOutOfMemory,
                fmt::format("page in {}: no memory for a frame of {} bytes", level.path.native(),
                            frame_bytes));
  }
}

Frame* Pager::Implementation::take_frame(SessionState& session, const LevelFile& level,
                                         std::uint64_t block) {
  if (vacant_.empty()) {
    Frame& added = frames_.emplace_back();
    added.index = static_cast<std::uint32_t>(frames_.size() - 1);
    vacant_.push_back(added);
  }
  // What a mapping holds for a block never written is not known to be zeros.
  const bool addressed = is_memory(level) || (level.traits.maps_for_reading && !level.writable &&
                                              was_written(level, block));
  const std::uint64_t frame_bytes = FramePool::frame_bytes(level.geometry.max_block_bytes());
  std::byte* memory = addressed ? level.backend->address(block) : nullptr;
  if (addressed && !pool_.reserve(frame_bytes)) return nullptr;
  if (!addressed) memory = pool_.take(frame_bytes);
  if (!memory) return nullptr;

  Frame& frame = vacant_.front();
  vacant_.pop_front();
  frame.content.level = &level;
  frame.content.block = block;
  frame.content.memory = memory;
  frame.content.block_bytes = level.geometry.block_bytes(block);
  frame.content.frame_bytes = frame_bytes;
  frame.content.state = State::kResident;
  frame.content.addressed = addressed;
  frame.transfer.backend = level.backend.get();
  frame.transfer.block = block;
  frame.transfer.memory = {memory, frame.content.block_bytes};
  frame.transfer.listener = this;
  frame.transfer.tag = frame.index;
  resident_[level.pager_slot][block] = frame.index;
  give(frame, &session);
  return &frame;
}

bool Pager::Implementation::make_room(Lock& lock, SessionState& session, const LevelFile& wanted_by,
                                      std::uint64_t wanted_bytes) {
  if (Frame* const clean = clean_victim(session, wanted_bytes)) {
    evict(*clean);
    return true;
  }
  if (Frame* const dirty = victim(session, wanted_bytes)) {
    write_here(lock, &session, *dirty);
    return false;
  }
  if (writes_in_flight_ > 0) {
    wait(lock, &session, Direction::kWrite);
    return false;
  }
  while (Frame* const last = last_announced(session, wanted_bytes)) {
    if (!last->content.dirty) {
      evict(*last);
      return true;
    }
    if (!failed_) {
      write_here(lock, &session, *last);
      return false;
    }
    unsettle(*last);  // its only copy: it stays
  }
  // Whoever reads a block may be done with it by then.
  if (reads_under_way_ > 0) {
    wait(lock, &session, Direction::kRead);
    return false;
  }
  if (wanted_bytes <= pool_.budget_bytes() && may_come_free(session)) {
    wait_for_room(lock, session);
    return false;
  }
  if (failed_) refuse(fmt::format("page in {}", wanted_by.path.native()));
  throw Error(
      ErrorCode::kBudget,
      fmt::format("page in {}: a frame of {} bytes is needed, and {} of {} bytes are available: "
                  "all others are pinned",
                  wanted_by.path.native(), wanted_bytes,
                  pool_.budget_bytes() - std::min(pool_.used_bytes(), pool_.budget_bytes()),
                  pool_.budget_bytes()));
}

bool Pager::Implementation::may_come_free(const SessionState& session) const noexcept {
  const auto waits = [&](std::thread::id thread) {
    return thread == std::this_thread::get_id() ||
           std::ranges::any_of(waiters_,
                               [&](const Waiter& waiter) { return waiter.thread == thread; });
  };
  return std::ranges::any_of(sessions_, [&](const SessionState& other) {
    return &other != &session && other.waiting == 0 &&
           std::ranges::any_of(other.callers, [&](const SessionState::Caller& caller) {
             return caller.pins > 0 && !waits(caller.thread);
           });
  });
}

void Pager::Implementation::wait_for_room(Lock& lock, SessionState& session) noexcept {
  Waiter waiter;
  waiters_.push_back(waiter);
  ++session.waiting;
  wait_for_change(lock, changes_);
  --session.waiting;
  waiters_.erase(waiters_.iterator_to(waiter));
}

std::uint64_t Pager::Implementation::share_bytes(const SessionState& session) const noexcept {
  if (session.options.share_bytes > 0)
    return std::min(session.options.share_bytes, pool_.budget_bytes());
  std::uint64_t left = pool_.budget_bytes(), equals = 0;
  for (const SessionState& other : sessions_) {
    if (other.options.share_bytes == 0) ++equals;
    left -= std::min(left, other.options.share_bytes);
  }
  return left / equals;
}

std::int64_t Pager::Implementation::excess_bytes(const SessionState& session) const noexcept {
  return static_cast<std::int64_t>(session.frame_bytes) -
         static_cast<std::int64_t>(share_bytes(session));
}

template <class Has>
SessionState* Pager::Implementation::furthest_over(const SessionState& asking,
                                                   std::uint64_t wanted_bytes, Has has) noexcept {
  SessionState* result = nullptr;
  std::int64_t most = 0;
  for (SessionState& session : sessions_) {
    if (!has(session)) continue;
    std::int64_t excess = excess_bytes(session);
    if (&session == &asking) excess += static_cast<std::int64_t>(wanted_bytes);
    if (result && excess <= most) continue;
    result = &session;
    most = excess;
  }
  return result;
}

Frame* Pager::Implementation::victim(const SessionState& asking,
                                     std::uint64_t wanted_bytes) noexcept {
  if (!left_.empty()) return &left_.front();
  SessionState* const session = furthest_over(
      asking, wanted_bytes, [](SessionState& of) { return of.eviction().victim() != nullptr; });
  return session ? session->eviction().victim() : nullptr;
}

/// nullptr: the next to be evicted is dirty, or there is none.
Frame* Pager::Implementation::clean_victim(const SessionState& asking,
                                           std::uint64_t wanted_bytes) noexcept {
  Frame* next = victim(asking, wanted_bytes);
  while (next && next->content.dirty && failed_) {
    unsettle(*next);  // its only copy: it stays
    next = victim(asking, wanted_bytes);
  }
  return next && !next->content.dirty ? next : nullptr;
}

Frame* Pager::Implementation::last_announced(const SessionState& asking,
                                             std::uint64_t wanted_bytes) noexcept {
  SessionState* const session =
      furthest_over(asking, wanted_bytes, [](const SessionState& of) { return !of.ahead.empty(); });
  return session ? &*session->ahead.rbegin() : nullptr;
}

void Pager::Implementation::give(Frame& frame, SessionState* session) noexcept {
  Frame::Content& content = frame.content;
  if (content.session == session) return;
  if (content.standing != Standing::kToWrite) unsettle(frame);
  unannounce(frame);
  if (SessionState* const former = std::exchange(content.session, session)) {
    former->frames.erase(former->frames.iterator_to(frame));
    former->frame_bytes -= content.frame_bytes;
  }
  if (!session) return;
  session->frames.push_back(frame);
  session->frame_bytes += content.frame_bytes;
  session->statistics.peak_frame_bytes =
      std::max(session->statistics.peak_frame_bytes, session->frame_bytes);
}

void Pager::Implementation::evict(Frame& frame) noexcept {
  ++statistics_.blocks_evicted;
  if (frame.content.session) ++frame.content.session->statistics.blocks_evicted;
  const bool mapped = frame.content.addressed && !is_memory(*frame.content.level);
  drop(frame);
  if (!mapped) return;
  vacant_.erase(vacant_.iterator_to(frame));
  frame.content.state = State::kLeaving;
  leaving_.push_back(frame);
}

void Pager::Implementation::tell_evicted(Lock& lock) noexcept {
  while (!leaving_.empty()) {
    Frame& frame = leaving_.front();
    leaving_.pop_front();
    lock.unlock();
    frame.transfer.backend->advise({frame.transfer.block, 1}, Advice::kDontNeed);
    lock.lock();
    vacate(frame);
  }
}

void Pager::Implementation::drop(Frame& frame) noexcept {
  unsettle(frame);
  unannounce(frame);
  give(frame, nullptr);
  const Frame::Content& content = frame.content;
  if (content.addressed)
    pool_.unreserve(content.frame_bytes);
  else
    pool_.give_back(content.memory, content.frame_bytes);
  std::uint32_t& resident = resident_[content.level->pager_slot][content.block];
  if (resident == frame.index) resident = kNoId;
  vacate(frame);
}

void Pager::Implementation::vacate(Frame& frame) noexcept {
  frame.content = {};
  vacant_.push_back(frame);
}

void Pager::Implementation::settle(Frame& frame) noexcept {
  Frame::Content& content = frame.content;
  if (content.abandoned) return drop(frame);
  if (content.dirty && failed_) return;
  if (content.dirty && is_memory(*content.level)) {
    mark_written(frame);
    if (content.dirty) return;
  }
  if (content.dirty && writes_behind(content.session)) return stand(frame, Standing::kToWrite, 0);
  const EdgeId edge_after = content.level->geometry.edge_after(content.block);
  if (!content.session) return stand(frame, Standing::kLeft, 0);
  stand(frame, content.announced ? Standing::kAhead : Standing::kEvictable, edge_after);
}

void Pager::Implementation::stand(Frame& frame, Standing standing, EdgeId order) noexcept {
  unsettle(frame);
  frame.content.standing = standing;
  frame.content.order = order;
  switch (standing) {
    case Standing::kNowhere:
      break;
    case Standing::kEvictable:
      frame.content.session->eviction().insert(frame);
      break;
    case Standing::kLeft:
      left_.push_back(frame);
      break;
    case Standing::kAhead:
      frame.content.session->ahead.insert(frame);
      break;
    case Standing::kToWrite:
      to_write_.push_back(frame);
      break;
  }
}

void Pager::Implementation::unsettle(Frame& frame) noexcept {
  switch (std::exchange(frame.content.standing, Standing::kNowhere)) {
    case Standing::kNowhere:
      break;
    case Standing::kEvictable:
      frame.content.session->eviction().erase(frame);
      break;
    case Standing::kLeft:
      left_.erase(left_.iterator_to(frame));
      break;
    case Standing::kAhead:
      frame.content.session->ahead.erase(frame.content.session->ahead.iterator_to(frame));
      break;
    case Standing::kToWrite:
      to_write_.erase(to_write_.iterator_to(frame));
      break;
  }
}

void Pager::Implementation::announce(Frame& frame) noexcept {
  if (!std::exchange(frame.content.announced, true))
    frame.content.session->announced_bytes += frame.content.frame_bytes;
}

void Pager::Implementation::unannounce(Frame& frame) noexcept {
  if (std::exchange(frame.content.announced, false))
    frame.content.session->announced_bytes -= frame.content.frame_bytes;
}

}  // namespace plait
