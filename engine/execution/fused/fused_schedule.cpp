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

std::optional<std::uint64_t> FusedSchedule::next() {
  std::unique_lock lock(mutex_);
  const std::uint64_t runs = faces_.run_count();
  moved_.wait(lock, [&] {
    return stopped_ || handed_out_ == runs || under_way_.empty() ||
           handed_out_ - *under_way_.begin() < runs_ahead_;
  });
  if (stopped_ || handed_out_ == runs) return std::nullopt;
  const std::uint64_t run = handed_out_++;
  under_way_.insert(run);
  return run;
}

void FusedSchedule::done(std::uint64_t run) {
  {
    const std::scoped_lock lock(mutex_);
    under_way_.erase(run);
    faces_done_ += faces_.run(run).size();
  }
  moved_.notify_all();
}

void FusedSchedule::stop() {
  {
    const std::scoped_lock lock(mutex_);
    stopped_ = true;
  }
  moved_.notify_all();
}

std::uint64_t FusedSchedule::faces_done() const {
  const std::scoped_lock lock(mutex_);
  return faces_done_;
}

PLAIT_END_NAMESPACE
