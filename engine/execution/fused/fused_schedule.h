// Gives runs of faces to threads, from the last face to the first.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <mutex>
#include <optional>
#include <vector>

#include "execution/fused/fused_faces.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// No thread gets more than `runs_ahead` runs ahead of the slowest thread. This limits the memory
/// of the faces in work. Safe from several threads. A thread takes a run from a counter, and locks
/// only to wait for a slower thread.
class FusedSchedule {
 public:
  /// `faces` must outlive this object.
  FusedSchedule(const FusedFaces& faces, int threads)
      : faces_(faces),
        runs_ahead_(runs_ahead(threads)),
        under_way_(static_cast<std::size_t>(threads)) {}

  static std::uint64_t run_faces(int levels);
  static std::uint64_t runs_ahead(int threads) { return 2 * static_cast<std::uint64_t>(threads); }

  /// The next run of `faces` for the thread with this number, or nothing if none is left or stop()
  /// was called. Waits if the slowest thread is too far behind.
  std::optional<std::uint64_t> next(int thread);
  /// The thread has ended its run.
  void done(int thread);
  void stop();
  std::uint64_t faces_done() const { return faces_done_; }

 private:
  static constexpr std::uint64_t kNone = std::numeric_limits<std::uint64_t>::max();
  struct alignas(64) UnderWay {
    std::atomic<std::uint64_t> run = kNone;  ///< of one thread
  };

  UnderWay& of(int thread) { return under_way_[static_cast<std::size_t>(thread)]; }
  bool may_begin(std::uint64_t run) const;
  void wake();

  const FusedFaces& faces_;
  const std::uint64_t runs_ahead_;
  std::atomic<std::uint64_t> next_ = 0, faces_done_ = 0;
  std::atomic<bool> stopped_ = false;
  std::vector<UnderWay> under_way_;  ///< [thread]

  std::atomic<std::uint32_t> waiting_ = 0;  ///< threads
  std::mutex mutex_;                        ///< only for waits
  std::condition_variable moved_;
};

PLAIT_END_NAMESPACE
