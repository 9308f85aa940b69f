// Blocks are pinned: all frames of a call are had before its first read begins, and given up before
// the call waits for anybody who may wait for it. So no two calls wait for each other.
//
// A call that brings blocks in waits for reads of others, too: at its end, when all of its own are
// under way, and before it begins the read of a block that is coded by others. The latter come
// earlier in the order of (level, attribute), and whoever brings in a block that comes earlier
// waits only for still earlier ones. So these waits end as well.
#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <new>
#include <utility>

#include "paging/pager_implementation.h"
#include "plait/error.h"

namespace plait {
namespace {

bool is_not_filled(Frame::State state) {
  return state == Frame::State::kClaimed || state == Frame::State::kReading;
}

bool is_missing(const PinBatch::Entry& entry) {
  return entry.brings_in && entry.frame->content.state == Frame::State::kClaimed &&
         entry.access != Access::kWrite;
}

bool is_ready(const PinBatch& batch, const PinBatch::Entry& entry) {
  const Frame::State state = entry.frame->content.state;
  if (is_not_filled(state)) return batch.overwrites(*entry.frame);
  return entry.access == Access::kRead || !is_being_written(state);
}

}  // namespace

std::uint32_t Pager::Implementation::pin(SessionState& session,
                                         std::span<const BlockRequest> requests,
                                         std::span<Frame*> frames) {
  for (const BlockRequest& request : requests)
    if (request.written() && !request.level().writable)
      throw Error(ErrorCode::kBadState, fmt::format("write {}: the level was opened for reading",
                                                    request.level().path.native()));
  Lock lock(mutex_);
  const auto check_writes = [&] {
    for (const BlockRequest& request : requests)
      if (request.written() && transfers_.failed())
        transfers_.refuse(fmt::format("write {}", request.level().path.native()));
  };
  check_writes();
  const std::uint32_t caller = session.caller();
  if (requests.size() == 1) {
    if (Frame* const frame = find_ready(requests[0])) {
      hold(session, *frame);
      if (requests[0].written()) {
        ++frame->content.writers;
        if (frame->content.state == State::kClean) become(*frame, State::kDirty);
      }
      session.add_pin(caller);
      frames[0] = frame;
      return caller;
    }
  }
  PinBatch batch(requests);
  try {
    while (!take_frames(lock, session, batch) || !bring_in(lock, session, batch)) {
      let_go(batch);
      check_writes();
    }
    check_writes();
  } catch (const std::bad_alloc&) {
    let_go(batch);
    throw Error(ErrorCode::kOutOfMemory,
                fmt::format("page in {}: no memory for {} bytes of frames",
                            requests[0].level().path.native(), batch.frame_bytes()));
  } catch (...) {
    let_go(batch);
    throw;
  }
  for (std::size_t at = 0; at < requests.size(); ++at) {
    if (requests[at].written()) add_writer(batch, at);
    session.add_pin(caller);
    frames[at] = batch[at].frame;
  }
  if (batch.size() > requests.size()) {
    for (std::size_t at = requests.size(); at < batch.size(); ++at) let_go(*batch[at].frame);
    transfers_.write_behind();
    tell_of_change();
  }
  return caller;
}

Frame* Pager::Implementation::find_ready(const BlockRequest& request) noexcept {
  Frame* const frame = table_.find(request.level(), request.block());
  if (!frame || !is_filled(frame->content.state)) return nullptr;
  if (!request.written()) return frame;
  if (is_being_written(frame->content.state)) return nullptr;
  std::array<ContextBlock, kMostContextBlocks> context;
  const bool has_context = frame->content.context_count > 0 || request.level().traits.in_memory ||
                           request.level().backend->context(request.block(), context) == 0;
  return has_context ? frame : nullptr;
}

bool Pager::Implementation::take_frames(Lock& lock, SessionState& session, PinBatch& batch) {
  for (std::size_t at = 0; at < batch.size(); ++at) {
    const LevelFile& level = *batch[at].level;
    const std::uint64_t block = batch[at].block;
    while (!batch[at].frame) {
      if (Frame* const frame = table_.find(level, block)) {
        if (batch[at].access != Access::kRead && is_being_written(frame->content.state)) {
          wait_while(lock, session, *frame, is_being_written);
          continue;
        }
        hold(session, *frame);
        batch[at].frame = frame;
      } else if (Frame* const taken = take_frame(session, level, block)) {
        ++taken->content.pins;
        batch[at].frame = taken;
        batch[at].brings_in = true;
      } else if (!make_room(lock, session, batch, level)) {
        return false;
      }
    }
    add_context(batch, at);
  }
  return true;
}

void Pager::Implementation::add_context(PinBatch& batch, std::size_t at) {
  const PinBatch::Entry entry = batch[at];
  const LevelFile& level = *entry.level;
  if (level.traits.in_memory || entry.frame->content.context_count > 0) return;
  const bool is_read =
      entry.brings_in && entry.access != Access::kWrite && was_written(level, entry.block);
  if (!is_read && entry.access == Access::kRead) return;
  std::array<ContextBlock, kMostContextBlocks> needed;
  const std::size_t count = level.backend->context(entry.block, needed);
  for (const ContextBlock& context : std::span(needed).first(count)) {
    const LevelFile* const other = table_.level(context.attribute, context.level);
    if (!other || context.block >= other->geometry.block_count() || !comes_before(*other, level))
      throw Error(ErrorCode::kBadState,
                  fmt::format("page in {}: block {} is coded by block {} of level {} of attribute "
                              "{}, expected a block of an open level that comes earlier",
                              level.path.native(), entry.block, context.block, context.level,
                              context.attribute));
    batch.add_context_of(at, *other, context.block);
  }
}

bool Pager::Implementation::bring_in(Lock& lock, SessionState& session, PinBatch& batch) {
  const bool reads = std::ranges::any_of(batch, is_missing);
  if (reads) ++bringing_in_;
  if (reads) read(lock, session, batch);
  while (PinBatch::Entry* const entry =
             batch.first([&](const PinBatch::Entry& other) { return !is_ready(batch, other); }))
    wait_while(lock, session, *entry->frame,
               is_not_filled(entry->frame->content.state) ? is_not_filled : is_being_written);
  if (reads) {
    // Not before: whoever waits for room would find these frames neither on their way nor free.
    --bringing_in_;
    tell_of_change();
  }
  bool others_failed = false;
  for (const PinBatch::Entry& entry : batch) {
    if (entry.frame->content.state != State::kDetached) continue;
    if (entry.brings_in && entry.frame->content.read_error)
      std::rethrow_exception(entry.frame->content.read_error);
    others_failed = true;
  }
  return !others_failed;
}

void Pager::Implementation::read(Lock& lock, SessionState& session, PinBatch& batch) {
  Frame* here = nullptr;
  for (PinBatch::Entry& entry : batch) {
    if (!is_missing(entry) || !was_written(*entry.level, entry.block)) continue;
    if (entry.level->traits.in_memory) {
      become(*entry.frame, State::kClean);
      count_transfer(*entry.frame, Direction::kRead);
    } else if (entry.context_count == 0) {
      transfers_.begin_read(*entry.frame);
      // This thread reads the last; it has nothing better to do.
      if (Frame* const before = std::exchange(here, entry.frame)) {
        if (transfers_.has_threads())
          transfers_.submit(*before);
        else
          transfers_.start(lock, *before);
      }
    }
  }
  if (here) {
    const Wait waiting(*this, &session, Direction::kRead);
    transfers_.start(lock, *here);
    changed_.wait(lock, [&] { return !is_not_filled(here->content.state); });
  }
  fill_with_zeros(lock, batch);
  read_with_context(lock, session, batch);
}

void Pager::Implementation::fill_with_zeros(Lock& lock, PinBatch& batch) noexcept {
  for (PinBatch::Entry& entry : batch) {
    if (!is_missing(entry) || was_written(*entry.level, entry.block)) continue;
    lock.unlock();
    std::memset(entry.frame->content.memory, 0, entry.frame->content.block_bytes);
    lock.lock();
    become(*entry.frame, State::kClean);
    tell_of_change();
  }
}

void Pager::Implementation::read_with_context(Lock& lock, SessionState& session,
                                              PinBatch& batch) noexcept {
  while (true) {
    PinBatch::Entry* next = nullptr;
    for (PinBatch::Entry& entry : batch)
      if (is_missing(entry) && (!next || comes_before(*entry.level, *next->level))) next = &entry;
    if (!next) return;
    Frame& frame = *next->frame;
    bool complete = true;
    for (std::size_t i = 0; i < next->context_count; ++i) {
      Frame& context = *batch[next->context + i].frame;
      if (is_not_filled(context.content.state)) wait_while(lock, session, context, is_not_filled);
      complete = complete && context.content.state != State::kDetached;
    }
    if (!complete) {
      frame.content.read_error = nullptr;  // the error is that of the context
      table_.detach_block(frame);
      tell_of_change();
      continue;
    }
    for (std::size_t i = 0; i < next->context_count; ++i) {
      frame.content.context[i] = batch[next->context + i].frame;
      ++frame.content.context[i]->content.pins;
    }
    frame.content.context_count = next->context_count;
    transfers_.begin_read(frame);
    const Wait waiting(*this, &session, Direction::kRead);
    transfers_.start(lock, frame);
  }
}

void Pager::Implementation::add_writer(PinBatch& batch, std::size_t at) noexcept {
  const PinBatch::Entry& entry = batch[at];
  Frame::Content& content = entry.frame->content;
#ifndef NDEBUG
  if (content.state == State::kClaimed && !content.addressed)
    std::memset(content.memory, 0xcd, content.block_bytes);
#endif
  ++content.writers;
  if (content.state == State::kClaimed || content.state == State::kClean)
    become(*entry.frame, State::kDirty);
  if (content.context_count > 0) return;
  for (std::size_t i = 0; i < entry.context_count; ++i) {
    content.context[i] = batch[entry.context + i].frame;
    ++content.context[i]->content.pins;
  }
  content.context_count = entry.context_count;
}

void Pager::Implementation::let_go(PinBatch& batch) noexcept {
  for (PinBatch::Entry& entry : batch) {
    Frame* const frame = std::exchange(entry.frame, nullptr);
    if (!frame) continue;
    // Whoever else waits for the block finds it absent, and brings it in.
    if (entry.brings_in && frame->content.state == State::kClaimed && frame->content.pins > 1)
      table_.detach_block(*frame);
    entry.brings_in = false;
    let_go(*frame);
  }
  batch.forget_context();
  transfers_.write_behind();
  tell_of_change();
}

}  // namespace plait
