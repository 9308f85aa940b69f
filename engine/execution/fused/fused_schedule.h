// Gives runs of faces to threads, from the last face to the first.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <optional>
#include <set>

#include "execution/fused/fused_faces.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// No thread gets more than `runs_ahead` runs ahead of the slowest thread. This limits the memory
/// of the faces in work. Safe from several threads.
class FusedSchedule {
 public:
  /// `faces` must outlive this object.
  FusedSchedule(const FusedFaces& faces, std::uint64_t runs_ahead)
      : faces_(faces), runs_ahead_(runs_ahead) {}

  static std::uint64_t run_faces(int levels);
  static std::uint64_t runs_ahead(int threads) { return 2 * static_cast<std::uint64_t>(threads); }

  /// The next run of `faces`, or nothing if none is left or stop() was called. Waits if the slowest
  /// thread is too far behind.
  std::optional<std::uint64_t> next();
  void done(std::uint64_t run);
  void stop();
  std::uint64_t faces_done() const;

 private:
  const FusedFaces& faces_;
  std::uint64_t runs_ahead_;
  mutable std::mutex mutex_;
  std::condition_variable moved_;
  std::uint64_t handed_out_ = 0, faces_done_ = 0;
  std::set<std::uint64_t> under_way_;  ///< runs in work
  bool stopped_ = false;
};

PLAIT_END_NAMESPACE
