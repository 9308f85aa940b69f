// Gives runs of faces to threads, from the last face to the first.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <optional>
#include <set>

#include "plait/extend/topology.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

struct FaceRun {
  FaceId first = 0, after = 0;
};

/// No thread gets more than `runs_ahead` runs ahead of the slowest thread. This limits the memory
/// of the faces in work. Safe from several threads.
class FusedSchedule {
 public:
  FusedSchedule(std::uint64_t face_count, std::uint64_t run_faces, std::uint64_t runs_ahead)
      : face_count_(face_count), run_faces_(run_faces), runs_ahead_(runs_ahead) {}

  static std::uint64_t run_faces(int levels);
  static std::uint64_t runs_ahead(int threads) { return 2 * static_cast<std::uint64_t>(threads); }

  /// The next run, or nothing if none is left or stop() was called. Waits if the slowest thread is
  /// too far behind.
  std::optional<FaceRun> next();
  void done(const FaceRun& run);
  void stop();
  std::uint64_t faces_done() const;

 private:
  std::uint64_t face_count_, run_faces_, runs_ahead_;
  mutable std::mutex mutex_;
  std::condition_variable moved_;
  std::uint64_t handed_out_ = 0, faces_done_ = 0;
  std::set<std::uint64_t> under_way_;  ///< runs in work, numbered in the order of next()
  bool stopped_ = false;
};

PLAIT_END_NAMESPACE
