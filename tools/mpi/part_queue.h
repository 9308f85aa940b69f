// tools/mpi/part_queue.h: which parts of a plan are handed out, and what became of them.
#pragma once

#include <cstdint>
#include <mutex>
#include <optional>
#include <vector>

namespace plait::mpi {

/// What became of a part. The numbers go from rank to rank.
enum class PartOutcome : int { kMade, kWasDone, kFailed, kCancelled };

/// Hands out each part once. Safe from several threads.
class PartQueue {
 public:
  explicit PartQueue(std::uint32_t parts) : parts_(parts) {}

  /// Nothing: all parts are handed out, or stop() was called.
  std::optional<std::uint32_t> next();
  void end(std::uint32_t part, PartOutcome outcome);
  /// No more parts are handed out.
  void stop();

  std::uint32_t ended() const;
  /// How many parts had this outcome.
  std::uint32_t count(PartOutcome outcome) const;
  /// The parts that failed, were cancelled or were not handed out, ascending.
  std::vector<std::uint32_t> not_done() const;

 private:
  mutable std::mutex mutex_;
  std::uint32_t parts_, next_ = 0;
  bool stopped_ = false;
  std::vector<std::uint32_t> not_done_;  ///< of those that ended
  std::uint32_t counts_[4] = {};         ///< for each PartOutcome
};

}  // namespace plait::mpi
