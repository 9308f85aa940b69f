// tools/mpi/part_queue.h: which parts of a plan are handed out, and what became of them.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <optional>
#include <vector>

namespace plait::mpi {

/// What became of a part. The numbers go from rank to rank.
enum class PartOutcome : int { kMade, kWasDone, kFailed, kCancelled };

/// Hands out each part once, and one that failed once more, to another rank: the reason may be the
/// machine. Safe from several threads.
class PartQueue {
 public:
  explicit PartQueue(std::uint32_t parts) : parts_(parts) {}

  /// A part for this rank. Nothing: there is none now, or stop() was called.
  std::optional<std::uint32_t> next(int rank);
  /// The same, but as long as another rank makes a part, which may fail there, it waits.
  std::optional<std::uint32_t> wait_for_next(int rank);
  /// What became of a part that next() has given to this rank.
  void end(std::uint32_t part, int rank, PartOutcome outcome);
  /// No more parts are handed out.
  void stop();

  std::uint32_t ended() const;
  /// How many parts had this outcome in the end.
  std::uint32_t count(PartOutcome outcome) const;
  /// The parts that failed, were cancelled or were not handed out, ascending.
  std::vector<std::uint32_t> not_done() const;

 private:
  struct Failure {
    std::uint32_t part;
    int rank;
  };
  std::optional<std::uint32_t> next_of(int rank);

  mutable std::mutex mutex_;
  std::condition_variable ended_;
  std::uint32_t parts_, next_ = 0, running_ = 0;
  bool stopped_ = false;
  std::vector<Failure> again_;           ///< for another rank
  std::vector<std::uint32_t> retried_;   ///< handed out a second time
  std::vector<std::uint32_t> not_done_;  ///< of those that ended
  std::uint32_t counts_[4] = {};         ///< for each PartOutcome
};

}  // namespace plait::mpi
