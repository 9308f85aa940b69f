#include "execution/fused/fused_schedule.h"

#include <algorithm>

#include "plait/extend/fused.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

std::uint64_t FusedSchedule::run_faces(int levels) {
  // A run has about a quarter of a million vertices, but at most kMostFaces faces, so that there
  // are enough runs for all threads.
  constexpr std::uint64_t kVertices = 1 << 18, kMostFaces = 512;
  return std::clamp<std::uint64_t>(kVertices >> (2 * levels), kPatchLanes, kMostFaces);
}

std::optional<std::uint64_t> FusedSchedule::next(int thread) {
  UnderWay& mine = of(thread);
  std::uint64_t run = next_;
  do {
    if (stopped_ || run == faces_.run_count()) {
      mine.run = kNone;
      wake();
      return std::nullopt;
    }
    // Before the thread takes the run: a thread that takes a later one then knows of it.
    mine.run = run;
  } while (!next_.compare_exchange_weak(run, run + 1));
  wake();  // if it first looked at a run that another thread took
  if (!may_begin(run)) {
    std::unique_lock lock(mutex_);
    ++waiting_;
    moved_.wait(lock, [&] { return stopped_ || may_begin(run); });
    --waiting_;
  }
  if (stopped_) return std::nullopt;
  return run;
}

bool FusedSchedule::may_begin(std::uint64_t run) const {
  return std::ranges::none_of(under_way_, [&](const UnderWay& other) {
    const std::uint64_t of_other = other.run;
    return of_other < run && run - of_other >= runs_ahead_;
  });
}

void FusedSchedule::done(int thread) {
  UnderWay& mine = of(thread);
  faces_done_ += faces_.run(mine.run).size();
  mine.run = kNone;
  wake();
}

/// To be called after a change. A thread that waits counts itself first, and then looks. So either
/// it sees the change, or this thread sees it.
void FusedSchedule::wake() {
  if (waiting_ == 0) return;
  { const std::scoped_lock lock(mutex_); }
  moved_.notify_all();
}

void FusedSchedule::stop() {
  stopped_ = true;
  wake();
}

PLAIT_END_NAMESPACE
