#include "base/interruption.h"

#include <fmt/format.h>

#include "base/caught.h"
#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

thread_local Interruptible* of_this_thread = nullptr;
thread_local bool is_worker = false;  ///< not the thread of the object itself

}  // namespace

Interruptible::Interruptible(std::string_view work, const ProgressCallback& progress,
                             std::chrono::milliseconds between)
    : work_(work),
      progress_(progress),
      between_(between),
      phase_(work),
      asked_(std::chrono::steady_clock::now()),
      outer_(of_this_thread) {
  of_this_thread = this;
}

Interruptible::~Interruptible() { of_this_thread = outer_; }

Interruptible* Interruptible::current() noexcept { return of_this_thread; }

ProgressCallback Interruptible::progress() {
  if (!progress_) return {};
  return [this](const Progress& now) {
    if (phase_ != now.phase) phase_ = now.phase;
    done_ = now.done;
    total_ = now.total;
    asked_ = std::chrono::steady_clock::now();
    return progress_(now);
  };
}

void Interruptible::ask() {
  if (is_over_.load(std::memory_order_relaxed)) std::rethrow_exception(failure_);
  const auto now = std::chrono::steady_clock::now();
  if (!progress_ || now - asked_ < between_) return;
  try {
    if (!progress_({phase_, done_, total_}))
      throw Error(ErrorCode::kCancelled, fmt::format("{}: cancelled", work_));
  } catch (...) {
    failure_ = caught_exception();
    is_over_.store(true, std::memory_order_release);
    throw;
  }
  asked_ = std::chrono::steady_clock::now();
}

InterruptibleWorker::InterruptibleWorker(Interruptible* of) noexcept
    : before_(of_this_thread), was_worker_(is_worker) {
  if (before_ == of) return;
  of_this_thread = of;
  is_worker = of != nullptr;
}

InterruptibleWorker::~InterruptibleWorker() {
  of_this_thread = before_;
  is_worker = was_worker_;
}

void poll_interruption() {
  Interruptible* const asked = of_this_thread;
  if (asked == nullptr) return;
  if (!is_worker) return asked->ask();
  if (asked->is_over_.load(std::memory_order_acquire)) std::rethrow_exception(asked->failure_);
}

PLAIT_END_NAMESPACE
