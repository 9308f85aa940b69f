// tools/mpi/ranks.h: how the ranks of an MPI job share out the parts of a plan. Rank 0 hands them
// out and makes some itself; the others ask it for one after another. A rank that waits sleeps,
// because MPI's own waiting takes a whole core.
#pragma once

#include <cstdint>
#include <functional>

#include "mpi/part_queue.h"

namespace plait::mpi {

/// Makes a part. Throws nothing.
using MakePart = std::function<PartOutcome(std::uint32_t part)>;

/// The job, from MPI_Init to MPI_Finalize. At most one object in a process, and all calls from the
/// thread that made it.
class Ranks {
 public:
  Ranks();
  ~Ranks();  ///< waits for all ranks
  Ranks(const Ranks&) = delete;
  Ranks& operator=(const Ranks&) = delete;

  int rank() const { return rank_; }
  int count() const { return count_; }

  /// Rank 0: hands out the parts until all that were handed out have ended and no rank asks for
  /// more. A thread of its own makes parts here. `watch` is called between messages, every few
  /// milliseconds.
  void hand_out(PartQueue& queue, const MakePart& make, const std::function<void()>& watch) const;
  /// The other ranks: makes what rank 0 hands out, until it says that this was all. Without
  /// `wants_parts` only waits for that.
  void work(const MakePart& make, bool wants_parts) const;

 private:
  int rank_ = 0, count_ = 1;
};

}  // namespace plait::mpi
