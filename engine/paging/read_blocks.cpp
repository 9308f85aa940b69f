// The second half of a PinCall: it reads the absent blocks into the frames that the call took.
#include <fmt/format.h>

#include <algorithm>
#include <boost/container/small_vector.hpp>
#include <cstring>
#include <exception>
#include <utility>

#include "base/damage.h"
#include "paging/pin_call.h"
#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

bool is_not_filled(Frame::State state) {
  return state == Frame::State::kClaimed || state == Frame::State::kReading;
}

bool is_missing(const PinBatch::WantedBlock& entry) {
  return entry.brings_in && entry.frame->content.state == Frame::State::kClaimed &&
         entry.access != Access::kOverwrite;
}

bool is_ready(const PinBatch& batch, const PinBatch::WantedBlock& entry) {
  const Frame::State state = entry.frame->content.state;
  if (is_not_filled(state))
    return batch.overwrites(*entry.frame) ||
           (entry.access == Access::kOverwrite && entry.frame->content.overwritten);
  return entry.access == Access::kRead || !is_being_written(state);
}

[[noreturn]] void throw_read_error(const std::exception_ptr& error) {
  try {
    std::rethrow_exception(error);
  } catch (const Error& damage) {
    if (damage.code() != ErrorCode::kCorruption) throw;
    throw with_cure(damage);
  }
}

}  // namespace

bool Pager::Implementation::PinCall::read_blocks() {
  const bool reads = std::ranges::any_of(batch_, is_missing);
  if (reads) read();
  while (PinBatch::WantedBlock* const entry = batch_.first(
             [&](const PinBatch::WantedBlock& other) { return !is_ready(batch_, other); }))
    pager_.wait_while(
        lock_, session_, *entry->frame,
        is_not_filled(entry->frame->content.state) ? is_not_filled : is_being_written);
  bool others_failed = false;
  for (const PinBatch::WantedBlock& entry : batch_) {
    if (entry.frame->content.state != State::kDetached) continue;
    if (entry.brings_in && entry.frame->content.read_error)
      throw_read_error(entry.frame->content.read_error);
    others_failed = true;
  }
  return !others_failed;
}

void Pager::Implementation::PinCall::read() {
  boost::container::small_vector<Frame*, 32> missing;
  for (const PinBatch::WantedBlock& entry : batch_) {
    if (!is_missing(entry) || !was_written(*entry.level, entry.block)) continue;
    if (entry.level->traits.in_memory) {
      become(*entry.frame, State::kClean);
      pager_.count_transfer(*entry.frame, Direction::kRead);
    } else if (entry.context_count == 0) {
      missing.push_back(entry.frame);
    }
  }
  std::ranges::sort(missing, {}, [](const Frame* frame) {
    return std::pair(frame->content.level->pager_slot, frame->content.block);
  });
  TransferRun here;
  for (Frame* const frame : missing) {
    pager_.transfers_.begin_read(*frame);
    if (!here.empty() && !follows(*here.transfers().back(), frame->transfer)) {
      // This thread reads the last run itself, because it would otherwise only wait.
      if (pager_.transfers_.has_threads())
        pager_.transfers_.submit(here);
      else
        pager_.transfers_.start(lock_, here);
      here = TransferRun();
    }
    here.add(frame->transfer);
  }
  if (!here.empty()) {
    const Wait waiting(pager_, &session_, Direction::kRead);
    pager_.transfers_.start(lock_, here);
    // A backend with threads of its own has only begun it. So this thread begins the others as
    // well, and does not wait for the I/O thread to wake up.
    for (Frame* const frame : missing)
      if (frame->content.state == State::kReading) pager_.transfers_.help(lock_, *frame);
    for (const QueuedTransfer* const transfer : here.transfers()) {
      const Frame& frame = pager_.table_[transfer->tag];
      pager_.changed_of(frame).wait(lock_, [&] { return !is_not_filled(frame.content.state); });
    }
  }
  fill_with_zeros();
  read_with_context();
}

void Pager::Implementation::PinCall::fill_with_zeros() noexcept {
  for (PinBatch::WantedBlock& entry : batch_) {
    if (!is_missing(entry) || was_written(*entry.level, entry.block)) continue;
    lock_.unlock();
    std::memset(entry.frame->content.memory, 0, entry.frame->content.block_bytes);
    lock_.lock();
    become(*entry.frame, State::kClean);
    pager_.wake_all();
  }
}

void Pager::Implementation::PinCall::read_with_context() noexcept {
  while (true) {
    // Begins all reads that need not wait for others. This thread reads the last block itself.
    Frame* here = nullptr;
    PinBatch::WantedBlock* earliest = nullptr;  // of those that wait for another block
    bool gave_up = false;
    for (PinBatch::WantedBlock& entry : batch_) {
      if (!is_missing(entry)) continue;
      if (Frame* const absent = absent_context(entry)) {
        if (absent->content.state != State::kDetached) {
          if (!earliest || comes_before(*entry.level, *earliest->level)) earliest = &entry;
          continue;
        }
        entry.frame->content.read_error = nullptr;  // reading the context failed, not this read
        pager_.table_.detach_block(*entry.frame);
        pager_.wake_all();
        gave_up = true;
        continue;
      }
      begin_read_with_context(entry);
      Frame* const before = std::exchange(here, entry.frame);
      if (before && pager_.transfers_.has_threads()) {
        pager_.transfers_.submit(*before);
      } else if (before) {
        const Wait waiting(pager_, &session_, Direction::kRead);
        pager_.transfers_.start(lock_, *before);
      }
    }
    if (here) {
      const Wait waiting(pager_, &session_, Direction::kRead);
      pager_.transfers_.start(lock_, *here);
    } else if (gave_up) {
      continue;  // blocks that are decoded with that one
    } else if (earliest) {
      // That block is being read, or another call has claimed it. The other call waits, if at all,
      // for a block that comes still earlier. So all waits end.
      pager_.wait_while(lock_, session_, *absent_context(*earliest), is_not_filled);
    } else {
      return;
    }
  }
}

Frame* Pager::Implementation::PinCall::absent_context(const PinBatch::WantedBlock& entry) noexcept {
  for (std::size_t i = 0; i < entry.context_count; ++i)
    if (Frame* const context = batch_[entry.context + i].frame;
        is_not_filled(context->content.state) || context->content.state == State::kDetached)
      return context;
  return nullptr;
}

void Pager::Implementation::PinCall::begin_read_with_context(
    const PinBatch::WantedBlock& entry) noexcept {
  pin_context(entry);
  pager_.transfers_.begin_read(*entry.frame);
}

PLAIT_END_NAMESPACE
