#include "plait/extend/pager.h"

#include <fmt/format.h>

#include <array>
#include <memory>
#include <new>
#include <utility>

#include "base/contention.h"
#include "blocks/kept_blocks.h"
#include "paging/pager_implementation.h"
#include "paging/pin_call.h"
#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

Pager::Implementation::Implementation(std::uint64_t budget_bytes, int io_threads,
                                      StoreEvents events)
    : events_(std::move(events)),
      table_(budget_bytes),
      sessions_(table_.pool()),
      transfers_(io_threads, *this) {
  transfers_.set_most_waiting(budget_bytes / kPartThatWaits);
}

Pager::Implementation::~Implementation() { discard(); }

void Pager::Implementation::attach(LevelFile& level) {
  check_usable();
  const Lock lock(mutex_);
  if (!level.traits.in_memory) transfers_.start_threads();
  with_memory_errors("open " + level.path.native(), [&] { table_.attach(level); });
}

void Pager::Implementation::detach(LevelFile& level) {
  Lock lock(mutex_);
  if (!table_.is_attached(level)) return;
  stop_transfers(lock, &level);
  for (Frame& frame : table_.frames())
    if (frame.content.level == &level) drop_context(frame);
  for (Frame& frame : table_.frames())
    if (frame.content.level == &level) drop(frame);
  table_.detach(level);
}

void Pager::Implementation::discard() noexcept {
  Lock lock(mutex_);
  stop_transfers(lock, nullptr);
  for (Frame& frame : table_.frames())
    if (frame.pins.close()) drop_context(frame);
  for (Frame& frame : table_.frames())
    if (frame.content.level && frame.pins.close()) drop(frame);
}

void Pager::Implementation::refuse_writes() noexcept {
  const Lock lock(mutex_);
  fail(nullptr);
}

void Pager::Implementation::set_aside(std::uint64_t bytes) noexcept {
  const Lock lock(mutex_);
  table_.pool().set_aside(bytes);
  transfers_.set_most_waiting(table_.pool().budget_bytes() / kPartThatWaits);
}

void Pager::Implementation::lend(std::int64_t bytes) noexcept {
  const Lock lock(mutex_);
  table_.pool().lend(bytes);
  transfers_.set_most_waiting(table_.pool().budget_bytes() / kPartThatWaits);
}

std::uint64_t Pager::Implementation::budget_bytes() const noexcept {
  const Lock lock(mutex_);
  return table_.pool().budget_bytes();
}

PagingStatistics Pager::Implementation::statistics() const {
  check_usable();
  const Lock lock(mutex_);
  PagingStatistics statistics = statistics_;
  statistics.peak_frame_bytes = table_.pool().peak_bytes();
  return statistics;
}

SessionState& Pager::Implementation::open_session(const SessionOptions& options) {
  check_usable();
  auto session = std::make_unique<SessionState>(this, options);
  const Lock lock(mutex_);
  if (options.policy == EvictionPolicy::kLayoutOrder) table_.find_needed_until();
  sessions_.add(*session);
  return *session.release();
}

void Pager::Implementation::end_session(SessionState& session) noexcept {
  if (!is_usable()) return;
  const Lock lock(mutex_);
  sessions_.end(session);
  if (session.callers.end_session()) delete &session;
  wake_all();
}

Pager::Implementation::Lock Pager::Implementation::lock() noexcept { return lock_soon(mutex_); }

SessionCaller* Pager::Implementation::pin_open(SessionState& session,
                                               std::span<const BlockRequest> requests,
                                               std::span<Frame*> frames) noexcept {
  for (std::size_t at = 0; at < requests.size(); ++at) {
    const BlockRequest& request = requests[at];
    Frame* const frame = FrameTable::look_up(request.level(), request.block());
    if (request.written() || !frame || !frame->pins.is_open() ||
        frame->open_to.load(std::memory_order_relaxed) != &session)
      return nullptr;
    frames[at] = frame;
  }
  const auto count = static_cast<std::uint32_t>(requests.size());
  // Counted before the pins, so that nobody who waits for a frame misses them.
  SessionCaller* const caller = session.callers.try_add(count);
  if (!caller) return nullptr;
  std::size_t pinned = 0;
  while (pinned < requests.size() && frames[pinned]->pins.try_add([&] {
    const BlockRequest& request = requests[pinned];
    return FrameTable::look_up(request.level(), request.block()) == frames[pinned];
  }))
    ++pinned;
  if (pinned == requests.size()) return caller;
  Lock lock;
  for (Frame* const frame : frames.first(pinned)) unpin(lock, *frame, nullptr, false);
  unpinned(lock);
  end_pins(session, *caller, count);
  return nullptr;
}

SessionCaller& Pager::Implementation::pin(SessionState& session,
                                          std::span<const BlockRequest> requests,
                                          std::span<Frame*> frames) try {
  check_usable();
  if (SessionCaller* const caller = pin_open(session, requests, frames)) return *caller;
  for (const BlockRequest& request : requests) {
    if (!request.written()) continue;
    if (!request.level().writable)
      throw Error(ErrorCode::kBadState, fmt::format("write {}: the level was opened for reading",
                                                    request.level().path.native()));
    if (request.level().committed)
      request.level().committed->keep(*request.written(), request.block());
  }
  Lock lock = this->lock();
  const auto count = static_cast<std::uint32_t>(requests.size());
  SessionCaller& caller = session.callers.add(count);
  if (find_ready(requests, frames)) {
    for (std::size_t i = 0; i < requests.size(); ++i)
      add_pin(session, *frames[i], requests[i].level().geometry.edge_after(requests[i].block()));
    if (requests[0].written()) add_writer(*frames[0]);
  } else {
    try {
      PinCall(*this, lock, session, requests).run(frames);
    } catch (...) {
      lock.unlock();
      end_pins(session, caller, count);
      throw;
    }
  }
  return caller;
} catch (const std::bad_alloc&) {
  throw out_of_memory("page in " + requests[0].level().path.native());
}

bool Pager::Implementation::find_ready(std::span<const BlockRequest> requests,
                                       std::span<Frame*> frames) noexcept {
  for (std::size_t at = 0; at < requests.size(); ++at) {
    if (requests.size() > 1 && requests[at].written()) return false;
    frames[at] = find_ready(requests[at]);
    if (!frames[at]) return false;
  }
  return true;
}

Frame* Pager::Implementation::find_ready(const BlockRequest& request) noexcept {
  Frame* const frame = table_.find(request.level(), request.block());
  if (!frame || !is_filled(frame->content.state)) return nullptr;
  if (!request.written()) return frame;
  if (is_being_written(frame->content.state) || transfers_.failed() || request.level().is_fixed)
    return nullptr;
  std::array<ContextBlock, kMostContextBlocks> context;
  const bool context_is_ready = frame->content.context_count > 0 ||
                                request.level().traits.in_memory ||
                                request.level().backend->context(request.block(), context) == 0;
  return context_is_ready ? frame : nullptr;
}

void Pager::Implementation::unpin(Lock& lock, Frame& frame, LevelFile* written,
                                  bool abandoned) noexcept {
  if (!written && frame.pins.try_end()) return;
  if (!lock) lock = this->lock();
  if (written) --frame.content.writers;
  if (written && abandoned) abandon(lock, frame, *written);
  remove_pin(frame);
}

void Pager::Implementation::unpinned(Lock& lock) noexcept {
  if (!lock) return;
  transfers_.write_behind();
  if (sessions_.anybody_waits()) wake_all();
  lock.unlock();
}

void Pager::Implementation::end_pins(SessionState& session, SessionCaller& caller,
                                     std::uint32_t pins) noexcept {
  if (caller.end(pins)) {
    const Lock held = lock();
    if (session.callers.end_one()) delete &session;
  }
  if (!sessions_.anybody_waits()) return;
  const Lock held = lock();
  wake_all();
}

PagingStatistics Pager::Implementation::statistics(const SessionState& session) const {
  check_usable();
  const Lock lock(mutex_);
  return session.statistics;
}

Pager::Pager(std::uint64_t budget_bytes, int io_threads, StoreEvents events)
    : implementation_(
          std::make_unique<Implementation>(budget_bytes, io_threads, std::move(events))) {}
Pager::~Pager() = default;
void Pager::attach(LevelFile& level) { implementation_->attach(level); }
void Pager::detach(LevelFile& level) { implementation_->detach(level); }

Session Pager::open_session(const SessionOptions& options) {
  return with_memory_errors("open session",
                            [&] { return Session(implementation_->open_session(options)); });
}

void Pager::flush() { implementation_->flush(); }
void Pager::wait_for_writes() noexcept { implementation_->wait_for_writes(); }
void Pager::refuse_writes() noexcept { implementation_->refuse_writes(); }
void Pager::discard() noexcept { implementation_->discard(); }
void Pager::set_aside(std::uint64_t bytes) noexcept { implementation_->set_aside(bytes); }
void Pager::lend(std::int64_t bytes) noexcept { implementation_->lend(bytes); }
std::uint64_t Pager::budget_bytes() const noexcept { return implementation_->budget_bytes(); }
PagingStatistics Pager::statistics() const { return implementation_->statistics(); }

PLAIT_END_NAMESPACE
