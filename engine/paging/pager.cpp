#include "plait/pager.h"

#include <fmt/format.h>

#include <new>
#include <utility>

#include "paging/pager_implementation.h"
#include "plait/error.h"

namespace plait {

Pager::Implementation::Implementation(std::uint64_t budget_bytes, int io_threads)
    : pool_(budget_bytes), queue_(io_threads) {}

Pager::Implementation::~Implementation() {
  Lock lock(mutex_);
  stop_transfers(lock, nullptr);
  for (Frame& frame : frames_)
    if (frame.content.level) drop(frame);
}

void Pager::Implementation::attach(LevelFile& level) {
  const Lock lock(mutex_);
  if (!is_memory(level)) queue_.start_threads();
  if (vacant_slots_.empty()) {
    vacant_slots_.reserve(resident_.size() + 1);
    level.pager_slot = static_cast<std::uint32_t>(resident_.size());
    resident_.emplace_back();
  } else {
    level.pager_slot = vacant_slots_.back();
    vacant_slots_.pop_back();
  }
  resident_[level.pager_slot].assign(level.geometry.block_count(), kNoId);
}

void Pager::Implementation::detach(LevelFile& level) {
  Lock lock(mutex_);
  if (level.pager_slot == kNoId) return;
  stop_transfers(lock, &level);
  tell_evicted(lock);
  for (const std::uint32_t index : resident_[level.pager_slot])
    if (index != kNoId) drop(frames_[index]);
  resident_[level.pager_slot].clear();
  vacant_slots_.push_back(std::exchange(level.pager_slot, kNoId));
}

SessionState& Pager::Implementation::open_session(const SessionOptions& options) {
  auto session = std::make_unique<SessionState>(*this, options);
  const Lock lock(mutex_);
  sessions_.push_back(*session);
  return *session.release();
}

void Pager::Implementation::end_session(SessionState& session) noexcept {
  const Lock lock(mutex_);
  session.ended = true;
  sessions_.erase(sessions_.iterator_to(session));
  // What its policy would give up first is the first of what it leaves.
  while (Frame* const frame = session.eviction().victim()) {
    give(*frame, nullptr);
    settle(*frame);
  }
  while (!session.frames.empty()) {
    Frame& frame = session.frames.front();
    const bool stood = frame.content.standing == Standing::kAhead;
    give(frame, nullptr);
    if (stood) settle(frame);
  }
  if (session.pins == 0) delete &session;
  tell_of_change();
}

Frame& Pager::Implementation::pin(SessionState& session, const BlockRequest& request,
                                  std::uint32_t& caller) {
  const LevelFile& level = request.level();
  const Access access = request.access();
  if (access != Access::kRead && !level.writable)
    throw Error(ErrorCode::kBadState,
                fmt::format("write {}: the level was opened for reading", level.path.native()));
  Lock lock(mutex_);
  caller = session.caller();
  while (true) {
    if (access != Access::kRead && failed_) refuse(fmt::format("write {}", level.path.native()));
    Frame* frame = frame_of(level, request.block());
    if (!frame) {
      frame = claim(lock, session, level, request.block());
      if (!frame) continue;
      bring_in(lock, session, *frame, access);
    } else {
      Frame::Content& content = frame->content;
      if (content.state == State::kReading ||
          (content.state == State::kWriting && access != Access::kRead)) {
        wait_for(lock, session, *frame);
        continue;
      }
      unsettle(*frame);
      unannounce(*frame);
      give(*frame, &session);
      ++content.pins;
      if (access != Access::kRead) content.dirty = true;
    }
    ++session.pins;
    ++session.callers[caller].pins;
    tell_evicted(lock);
    return *frame;
  }
}

void Pager::Implementation::unpin(SessionState& session, std::uint32_t caller, std::uint32_t index,
                                  LevelFile* abandoned) noexcept {
  const Lock lock(mutex_);
  --session.callers[caller].pins;
  if (--session.pins == 0 && session.ended) delete &session;
  Frame& frame = frames_[index];
  if (abandoned) frame.content.abandoned = abandoned->left_unfinished = true;
  if (--frame.content.pins == 0 && frame.content.state == State::kResident) {
    settle(frame);
    write_behind();
  }
  if (!waiters_.empty()) tell_of_change();
}

void Pager::Implementation::refuse_writes() noexcept {
  const Lock lock(mutex_);
  fail(nullptr);
}

void Pager::Implementation::discard() noexcept {
  Lock lock(mutex_);
  stop_transfers(lock, nullptr);
  for (Frame& frame : frames_)
    if (frame.content.level && frame.content.pins == 0) drop(frame);
}

void Pager::Implementation::set_aside(std::uint64_t bytes) noexcept {
  const Lock lock(mutex_);
  pool_.set_aside(bytes);
}

std::uint64_t Pager::Implementation::budget_bytes() const noexcept {
  const Lock lock(mutex_);
  return pool_.budget_bytes();
}

PagingStatistics Pager::Implementation::statistics() const {
  const Lock lock(mutex_);
  PagingStatistics statistics = statistics_;
  statistics.peak_frame_bytes = pool_.peak_bytes();
  return statistics;
}

PagingStatistics Pager::Implementation::statistics(const SessionState& session) const {
  const Lock lock(mutex_);
  return session.statistics;
}

Pager::Pager(std::uint64_t budget_bytes, int io_threads)
    : implementation_(std::make_unique<Implementation>(budget_bytes, io_threads)) {}
Pager::~Pager() = default;
void Pager::attach(LevelFile& level) { implementation_->attach(level); }
void Pager::detach(LevelFile& level) { implementation_->detach(level); }

Session Pager::open_session(const SessionOptions& options) {
  try {
    return Session(implementation_->open_session(options));
  } catch (const std::bad_alloc&) {
    throw Error(ErrorCode::kOutOfMemory, "open session: no memory for its state");
  }
}

void Pager::flush() { implementation_->flush(); }
void Pager::refuse_writes() noexcept { implementation_->refuse_writes(); }
void Pager::discard() noexcept { implementation_->discard(); }

void Pager::set_aside(std::uint64_t bytes) noexcept { implementation_->set_aside(bytes); }

std::uint64_t Pager::budget_bytes() const noexcept { return implementation_->budget_bytes(); }
PagingStatistics Pager::statistics() const { return implementation_->statistics(); }

}  // namespace plait
