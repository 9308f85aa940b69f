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

std::optional<FaceRun> FusedSchedule::next() {
  std::unique_lock lock(mutex_);
  const std::uint64_t runs = (face_count_ + run_faces_ - 1) / run_faces_;
  moved_.wait(lock, [&] {
    return stopped_ || handed_out_ == runs || under_way_.empty() ||
           handed_out_ - *under_way_.begin() < runs_ahead_;
  });
  if (stopped_ || handed_out_ == runs) return std::nullopt;
  const std::uint64_t number = handed_out_++;
  under_way_.insert(number);
  const std::uint64_t after = face_count_ - number * run_faces_;
  return FaceRun{static_cast<FaceId>(after - std::min(after, run_faces_)),
                 static_cast<FaceId>(after)};
}

void FusedSchedule::done(const FaceRun& run) {
  {
    const std::scoped_lock lock(mutex_);
    under_way_.erase((face_count_ - run.after) / run_faces_);
    faces_done_ += run.after - run.first;
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
