// The part of the pager that takes, pins and frees frames.
#include <array>
#include <atomic>

#include "paging/pager_implementation.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// Enough for blocks on their way to the disk and for those that are being filled.
constexpr std::uint64_t kMostWrittenBytes = std::uint64_t{32} << 20;

}  // namespace

Frame* Pager::Implementation::take_frame(SessionState& session, const LevelFile& level,
                                         std::uint64_t block) {
  // A block that was never written reads as zeros, but a mapping may contain other bytes there.
  const bool addressed = level.traits.in_memory || (level.traits.maps_for_reading &&
                                                    !level.writable && was_written(level, block));
  Frame* const frame =
      table_.claim(level, block, addressed ? level.backend->address(block) : nullptr);
  if (frame) sessions_.give(*frame, &session);
  return frame;
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
  const Frame::Content evicted = frame.content;
  drop(frame);
  tell(lock, StoreEvent::Kind::kEvicted, evicted);
  if (!mapped) return;
  lock.unlock();
  backend.advise({block, 1}, Advice::kDontNeed);
  lock.lock();
}

bool Pager::Implementation::evict_written(Lock& lock, SessionState& session) noexcept {
  if (!session.options.only_writes || session.frame_bytes < kMostWrittenBytes) return false;
  Frame* const oldest = session.eviction().victim(0);
  if (!oldest) return false;
  const Frame::Content& content = oldest->content;
  if (content.state != State::kClean || !content.overwritten ||
      !content.level->traits.in_page_cache)
    return false;
  evict(lock, *oldest);
  return true;
}

void Pager::Implementation::tell(Lock& lock, StoreEvent::Kind kind, const Frame::Content& content,
                                 std::uint64_t duration_ns) noexcept {
  if (!events_.call) return;
  StoreEvent event;
  event.kind = kind;
  event.duration_ns = duration_ns;
  event.level = content.level->table.level();
  event.block = content.block;
  event.bytes = content.block_bytes;
  // A copy, because the level may be closed while nobody has the lock.
  std::array<char, 256> name;
  const std::size_t length = content.level->attribute.copy(name.data(), name.size());
  event.attribute = {name.data(), length};
  lock.unlock();
  events_.tell(event);
  lock.lock();
}

bool Pager::Implementation::may_open(const Frame& frame) noexcept {
  const Frame::Content& content = frame.content;
  return (content.state == State::kClean || content.state == State::kDirty) && content.session &&
         !content.announced && !frame.to_write.is_linked() &&
         content.order == content.level->geometry.edge_after(content.block);
}

void Pager::Implementation::open(Frame& frame) noexcept {
  if (!may_open(frame)) return;
  frame.open_to.store(frame.content.session, std::memory_order_relaxed);
  frame.pins.open();
}

void Pager::Implementation::add_pin(SessionState& session, Frame& frame, EdgeId order) noexcept {
  sessions_.give(frame, &session);
  frame.content.order = order;
  transfers_.cancel_write(frame);
  frame.open_to.store(&session, std::memory_order_relaxed);
  frame.pins.add(may_open(frame));
}

void Pager::Implementation::add_writer(Frame& frame) noexcept {
  ++frame.content.writers;
  if (frame.content.state == State::kDirty) return;
  const bool was_claimed = frame.content.state == State::kClaimed;
  become(frame, State::kDirty);
  // Another call may wait until the block is filled.
  if (was_claimed) wake_waiters_of(frame);
}

void Pager::Implementation::remove_pin(Frame& frame) noexcept {
  if (frame.pins.end()) place_unpinned(frame);
}

void Pager::Implementation::place_unpinned(Frame& frame) noexcept {
  Frame::Content& content = frame.content;
  if (content.state == State::kClaimed || content.state == State::kDetached) return drop(frame);
  if (content.state == State::kDirty && transfers_.failed()) become(frame, State::kStuck);
  if (content.state == State::kDirty && content.level->traits.in_memory) write_in_memory(frame);
  if (content.state == State::kDirty && writes_behind(content.session))
    transfers_.queue_write(frame);
  else if (content.state == State::kClean || content.state == State::kDirty)
    sessions_.place(frame);
  if (Sessions::is_placed(frame)) open(frame);
}

void Pager::Implementation::drop(Frame& frame) noexcept {
  transfers_.cancel_write(frame);
  sessions_.give(frame, nullptr);
  drop_context(frame);
  table_.vacate(frame);
}

void Pager::Implementation::drop_context(Frame& frame) noexcept {
  for (std::size_t i = 0; i < frame.content.context_count; ++i)
    remove_pin(*frame.context->blocks[i]);
  frame.content.context_count = 0;
}

PLAIT_END_NAMESPACE
