// The part of the pager that ends transfers, waits for them, prefetches and flushes.
#include <algorithm>
#include <array>
#include <exception>
#include <memory>
#include <utility>
#include <vector>

#include "base/caught.h"
#include "paging/pager_implementation.h"
#include "paging/pin_batch.h"
#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

void Pager::Implementation::finished(Transfer& transfer, std::exception_ptr error) noexcept {
  Lock lock(mutex_);
  Frame& frame = table_[transfer.tag];
  const Frame::Content content = frame.content;
  const bool was_read = frame.content.state == State::kReading;
  transfers_.ended(frame, error);
  if (!error) count_transfer(frame, transfer.direction);
  if (was_read && error) {
    // Calls that wait for the block then find it absent, and read it themselves.
    frame.content.read_error = error;
    table_.detach_block(frame);
  } else if (error) {
    fail(error);
  }
  if (was_read || frame.content.state == State::kClean) drop_context(frame);
  if (!frame.pins.any())
    place_unpinned(frame);
  else
    open(frame);
  transfers_.write_behind();
  wake_waiters_of(frame);
  if (!was_read || error || !events_.call) return;
  const auto passed = static_cast<std::uint64_t>(
      std::chrono::nanoseconds(std::chrono::steady_clock::now() - content.read_began).count());
  if (passed > events_.slow_read_ns) tell(lock, StoreEvent::Kind::kSlowRead, content, passed);
}

void Pager::Implementation::count_transfer(const Frame& frame, Direction direction) noexcept {
  const bool read = direction == Direction::kRead;
  const auto count = [&](PagingStatistics& statistics) {
    ++(read ? statistics.blocks_read : statistics.blocks_written);
    (read ? statistics.bytes_read : statistics.bytes_written) += frame.content.block_bytes;
  };
  count(statistics_);
  if (frame.content.session) count(frame.content.session->statistics);
}

void Pager::Implementation::wake_all() noexcept {
  ++changes_;
  changed_.notify_all();
  for (std::condition_variable& each : frame_changed_) each.notify_all();
}

void Pager::Implementation::wake_waiters_of(const Frame& frame) noexcept {
  ++changes_;
  changed_.notify_all();
  changed_of(frame).notify_all();
}

void Pager::Implementation::wait_for_any(Lock& lock, SessionState* session,
                                         Direction direction) noexcept {
  const Wait waiting(*this, session, direction);
  const std::uint64_t before = changes_;
  if (!transfers_.help_any(lock, direction)) wait_for_change(lock, before);
}

void Pager::Implementation::wait_while(Lock& lock, SessionState& session, Frame& frame,
                                       bool (*what)(State)) noexcept {
  const Frame::Content& content = frame.content;
  const Wait waiting(*this, &session,
                     is_being_written(content.state) ? Direction::kWrite : Direction::kRead);
  const LevelFile* const level = content.level;
  const std::uint64_t block = content.block;
  transfers_.help(lock, frame);
  changed_of(frame).wait(lock, [&] {
    return !what(content.state) || content.level != level || content.block != block;
  });
}

bool Pager::Implementation::prefetch(SessionState& session, const LevelFile& level,
                                     std::uint64_t block, std::uint64_t count) noexcept {
  if (!is_usable()) return false;
  const BlockRange run = run_of(level, block);
  const std::uint64_t rest = run.first + run.count - block;
  Lock lock(mutex_);
  try {
    return begin_prefetch(lock, session, level, {block, std::min(count, rest)},
                          level.geometry.edge_after(block));
  } catch (const std::exception&) {
    return false;  // the pin of the block will get the error
  }
}

bool Pager::Implementation::read_ahead(SessionState& session, const LevelFile& level,
                                       std::uint64_t block, std::uint64_t count) noexcept {
  if (!is_usable()) return false;
  if (Frame* const frame = FrameTable::look_up(level, block);
      frame && frame->pins.is_open() &&
      frame->open_to.load(std::memory_order_relaxed) == &session) {
    frame->pins.keep_used();
    return true;
  }
  return prefetch(session, level, block, count);
}

void Pager::Implementation::end_prefetch(SessionState& session) noexcept {
  if (!is_usable()) return;
  const Lock lock(mutex_);
  for (auto next = session.frames.begin(); next != session.frames.end();) {
    Frame& frame = *next++;
    if (!frame.content.announced) continue;
    sessions_.withdraw(frame);
    if (frame.content.state == State::kReading && !frame.pins.any() && transfers_.withdraw(frame))
      drop(frame);
  }
  wake_all();
}

bool Pager::Implementation::begin_prefetch(Lock& lock, SessionState& session,
                                           const LevelFile& level, BlockRange blocks,
                                           EdgeId order) {
  const std::uint64_t block = blocks.first;
  if (Frame* const frame = table_.find(level, block)) {
    const Frame::Content& content = frame->content;
    if (content.announced || content.state == State::kStuck) return true;
    if (frame->pins.any() || !frame->pins.close()) return true;
    const bool placed = Sessions::is_placed(*frame);
    sessions_.give(*frame, &session);
    frame->content.order = order;
    sessions_.announce(*frame);
    if (placed) sessions_.place(*frame);
    return true;
  }
  // The system is not asked to read ahead (posix_fadvise): that costs a sweep as much time as the
  // read itself (docs/benchmarks.md).
  if (!was_written(level, block) || level.traits.in_memory || !transfers_.has_threads())
    return true;
  if (!transfers_.may_begin(Direction::kRead) || !has_share_for(session, level)) return false;

  // The context of the block must be in memory first. A prefetch must not begin a read that would
  // have to wait for another one.
  std::array<ContextBlock, kMostContextBlocks> needed;
  std::array<Frame*, kMostContextBlocks> context{};
  const std::size_t context_count = level.backend->read_context(block, needed);
  for (std::size_t i = 0; i < context_count; ++i) {
    const LevelFile* const other = table_.level(needed[i].attribute, needed[i].level);
    if (!other || !comes_before(*other, level)) return true;  // the pin will get the error
    context[i] = table_.find(*other, needed[i].block);
    if (!context[i])
      static_cast<void>(begin_prefetch(lock, session, *other, {needed[i].block, 1}, order));
    if (!context[i] || !is_filled(context[i]->content.state)) return false;
  }
  for (std::size_t i = 0; i < context_count; ++i) {
    add_pin(session, *context[i], order);
    keep_as_context(*context[i], table_.needed_until(*context[i]->content.level, needed[i].block));
  }
  Frame* frame = nullptr;
  std::unique_ptr<FrameContext> made;
  try {
    if (context_count > 0) made = std::make_unique<FrameContext>();
    frame = take_frame_ahead(lock, session, level, block);
  } catch (...) {
    for (std::size_t i = 0; i < context_count; ++i) remove_pin(*context[i]);
    throw;
  }
  if (!frame) {
    for (std::size_t i = 0; i < context_count; ++i) remove_pin(*context[i]);
    transfers_.write_behind();
    return table_.find(level, block) != nullptr;
  }
  frame->content.order = order;
  if (context_count > 0) {
    if (!frame->context) frame->context = std::move(made);
    std::copy_n(context.begin(), context_count, frame->context->blocks.begin());
    frame->content.context_count = context_count;
  }
  TransferRun run;
  add_read_ahead(run, session, *frame);
  try {
    for (std::uint64_t at = 1; at < blocks.count && has_share_for(session, level); ++at) {
      // The block's table entry may be read only where no frame has it, which could be written.
      if (table_.find(level, block + at) || !was_written(level, block + at)) break;
      Frame* const next = take_frame_ahead(lock, session, level, block + at);
      if (!next) break;
      add_read_ahead(run, session, *next);
    }
  } catch (const std::exception&) {  // the pin of that block will get the error
  }
  transfers_.submit(run);
  return true;
}

bool Pager::Implementation::has_share_for(const SessionState& session,
                                          const LevelFile& level) const noexcept {
  return session.announced_bytes + FrameTable::frame_bytes(level) + session.options.window_bytes <=
         sessions_.share_bytes(session);
}

Frame* Pager::Implementation::take_frame_ahead(Lock& lock, SessionState& session,
                                               const LevelFile& level, std::uint64_t block) {
  while (!table_.find(level, block)) {
    if (Frame* const frame = take_frame(session, level, block)) return frame;
    Frame* const clean = clean_victim(session, FrameTable::frame_bytes(level));
    if (!clean) break;
    evict(lock, *clean);
  }
  return nullptr;
}

void Pager::Implementation::add_read_ahead(TransferRun& run, SessionState& session,
                                           Frame& frame) noexcept {
  sessions_.announce(frame);
  ++statistics_.blocks_prefetched;
  ++session.statistics.blocks_prefetched;
  transfers_.begin_read(frame);
  run.add(frame.transfer);
}

/// Writes a dirty block of a level in memory: the backend only marks the block as written.
void Pager::Implementation::write_in_memory(Frame& frame) noexcept {
  try {
    frame.transfer.backend->write({frame.content.block, 1}, frame.transfer.memory);
    if (frame.content.writers == 0) become(frame, State::kClean);
    count_transfer(frame, Direction::kWrite);
  } catch (...) {
    fail(caught_exception());
  }
}

void Pager::Implementation::write_here(Lock& lock, SessionState* session, Frame& frame) {
  const Wait waiting(*this, session, Direction::kWrite);
  const std::uint64_t before = changes_;
  Sessions::unplace(frame);
  transfers_.begin_write(frame);
  transfers_.start(lock, frame);
  if (changes_ == before) wait_for_change(lock, before);
  if (transfers_.failed()) transfers_.refuse("write back");
}

void Pager::Implementation::abandon(Lock& lock, Frame& frame, LevelFile& level) noexcept {
  level.left_unfinished = true;
  changed_.wait(lock, [&] { return !is_being_written(frame.content.state); });
  if (frame.content.state == State::kDetached) return;
  drop_context(frame);
  table_.detach_block(frame);
}

void Pager::Implementation::fail(std::exception_ptr error) noexcept {
  transfers_.fail(std::move(error));
  for (Frame& frame : table_.frames()) {
    if (frame.content.state != State::kDirty) continue;
    // A frame that is pinned becomes stuck when its last pin ends.
    const bool has_no_pins = frame.pins.claim();
    Sessions::unplace(frame);
    if (has_no_pins) become(frame, State::kStuck);
  }
}

/// Writes the first of these frames, and those behind it that are of the same run. REQUIRES: the
/// first one is dirty. Returns how many these are; a block that is pinned for writing is dirty
/// again.
std::size_t Pager::Implementation::write_run(Lock& lock, std::span<Frame* const> frames) noexcept {
  TransferRun run;
  for (Frame* const frame : frames) {
    if (!run.empty() && (frame->content.state != State::kDirty ||
                         !follows(*run.transfers().back(), frame->transfer)))
      break;
    Sessions::unplace(*frame);
    transfers_.begin_write(*frame);
    run.add(frame->transfer);
  }
  const std::size_t count = run.transfers().size();
  if (transfers_.has_threads()) {
    transfers_.submit(run);
  } else {
    const Wait waiting(*this, nullptr, Direction::kWrite);
    transfers_.start(lock, run);
  }
  return count;
}

void Pager::Implementation::flush() {
  check_usable();
  Lock lock(mutex_);
  if (transfers_.failed()) transfers_.refuse("flush");
  std::vector<Frame*> dirty;
  for (Frame& frame : table_.frames())
    if (frame.content.state == State::kDirty) dirty.push_back(&frame);
  std::ranges::sort(dirty, {}, [](const Frame* frame) {
    return std::pair(frame->content.level->pager_slot, frame->content.block);
  });
  for (std::size_t at = 0; at < dirty.size();) {
    while (!transfers_.failed() && !transfers_.may_begin(Direction::kWrite))
      wait_for_any(lock, nullptr, Direction::kWrite);
    if (transfers_.failed()) break;
    if (dirty[at]->content.state != State::kDirty) {
      ++at;
    } else if (dirty[at]->content.level->traits.in_memory) {
      write_in_memory(*dirty[at++]);
    } else {
      at += write_run(lock, std::span(dirty).subspan(at));
    }
  }
  while (transfers_.writes() > 0) wait_for_any(lock, nullptr, Direction::kWrite);
  if (transfers_.failed()) transfers_.refuse("flush");
}

void Pager::Implementation::wait_for_writes() noexcept {
  Lock lock(mutex_);
  while (transfers_.write_waiting()) continue;
  transfers_.write_behind();
  while (transfers_.writes() > 0) wait_for_any(lock, nullptr, Direction::kWrite);
}

void Pager::Implementation::stop_transfers(Lock& lock, const LevelFile* level) noexcept {
  const auto concerned = [&](const Frame& frame) {
    return is_on_its_way(frame.content.state) && (!level || frame.content.level == level);
  };
  for (Frame& frame : table_.frames()) {
    if (!level || frame.content.level == level) transfers_.cancel_write(frame);
    const bool wanted = frame.content.state == State::kReading && frame.pins.any();
    if (concerned(frame) && !wanted && transfers_.withdraw(frame) &&
        frame.content.state == State::kClaimed)
      drop(frame);
  }
  changed_.wait(lock, [&] { return std::ranges::none_of(table_.frames(), concerned); });
}

PLAIT_END_NAMESPACE
