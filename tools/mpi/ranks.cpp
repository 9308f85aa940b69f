#include "mpi/ranks.h"

#include <mpi.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <optional>
#include <thread>
#include <vector>

#include "base/threads.h"

namespace plait::mpi {
namespace {

constexpr int kAskTag = 1, kPartTag = 2;
constexpr int kNoPart = -1;
/// Where parts fail one after another, the machine is to blame. It would take all parts from the
/// others, because it is the fastest to ask for the next one.
constexpr int kMostFailures = 3;

/// What a rank tells rank 0: which part has ended, and whether it wants another one.
struct Asking {
  int part = kNoPart, outcome = 0, wants_more = 1;
};
constexpr int kAskingNumbers = 3;
static_assert(sizeof(Asking) == kAskingNumbers * sizeof(int));

/// Sleeps longer each time, up to a limit that no part notices.
class Pause {
 public:
  void sleep() {
    std::this_thread::sleep_for(time_);
    time_ = std::min(2 * time_, kLongest);
  }

 private:
  static constexpr std::chrono::milliseconds kLongest{16};
  std::chrono::milliseconds time_{1};
};

/// Whether a rank goes on after a part. One that was cancelled or fails again and again does not.
class Endurance {
 public:
  bool goes_on(PartOutcome outcome) {
    failures_ = outcome == PartOutcome::kFailed ? failures_ + 1 : 0;
    return failures_ < kMostFailures && outcome != PartOutcome::kCancelled;
  }

 private:
  int failures_ = 0;
};

void send_part(int rank, int part) { MPI_Send(&part, 1, MPI_INT, rank, kPartTag, MPI_COMM_WORLD); }

int receive_part() {
  int part = kNoPart, is_here = 0;
  MPI_Request request = MPI_REQUEST_NULL;
  MPI_Irecv(&part, 1, MPI_INT, 0, kPartTag, MPI_COMM_WORLD, &request);
  for (Pause pause;; pause.sleep()) {
    MPI_Test(&request, &is_here, MPI_STATUS_IGNORE);
    if (is_here != 0) return part;
  }
}

struct Asked {
  int rank = 0;
  Asking asking;
};

std::optional<Asked> receive_asking() {
  int is_here = 0;
  MPI_Status status;
  MPI_Iprobe(MPI_ANY_SOURCE, kAskTag, MPI_COMM_WORLD, &is_here, &status);
  if (is_here == 0) return std::nullopt;
  Asked asked;
  asked.rank = status.MPI_SOURCE;
  MPI_Recv(&asked.asking, kAskingNumbers, MPI_INT, asked.rank, kAskTag, MPI_COMM_WORLD,
           MPI_STATUS_IGNORE);
  return asked;
}

}  // namespace

Ranks::Ranks() {
  int provided = 0;
  // Rank 0 has a second thread, which does not call MPI.
  MPI_Init_thread(nullptr, nullptr, MPI_THREAD_FUNNELED, &provided);
  MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
  MPI_Comm_size(MPI_COMM_WORLD, &count_);
}

Ranks::~Ranks() { MPI_Finalize(); }

void Ranks::hand_out(PartQueue& queue, const MakePart& make,
                     const std::function<void()>& watch) const {
  std::atomic<bool> has_ended = false;
  JoinedThreads own;
  // The first part is this rank's own, however fast the others are.
  own.start("the thread of this rank's own parts", [&, part = queue.next(0)]() mutable {
    Endurance endurance;
    while (part) {
      const PartOutcome outcome = make(*part);
      queue.end(*part, 0, outcome);
      part = endurance.goes_on(outcome) ? queue.wait_for_next(0) : std::nullopt;
    }
    has_ended = true;
  });
  // Ranks that get no more parts are told so at the end: until then they sleep, and afterwards MPI
  // waits in its own way. Those that want more get a part that fails at another rank.
  std::vector<int> idle, willing;
  const auto give = [&](int rank) {
    const std::optional<std::uint32_t> part = queue.next(rank);
    if (part) send_part(rank, static_cast<int>(*part));
    return part.has_value();
  };
  Pause pause;
  for (;;) {
    watch();
    // Read before the ranks are asked: what its last part has left is then in the queue.
    const bool all_wait =
        has_ended && idle.size() + willing.size() + 1 == static_cast<std::size_t>(count_);
    std::erase_if(willing, give);
    if (all_wait && idle.size() + willing.size() + 1 == static_cast<std::size_t>(count_)) break;
    const std::optional<Asked> asked = receive_asking();
    if (!asked) {
      pause.sleep();
      continue;
    }
    pause = {};
    const Asking& asking = asked->asking;
    if (asking.part != kNoPart)
      queue.end(static_cast<std::uint32_t>(asking.part), asked->rank,
                static_cast<PartOutcome>(asking.outcome));
    if (asking.wants_more == 0)
      idle.push_back(asked->rank);
    else if (!give(asked->rank))
      willing.push_back(asked->rank);
  }
  idle.insert(idle.end(), willing.begin(), willing.end());
  for (const int rank : idle) send_part(rank, kNoPart);
}

void Ranks::work(const MakePart& make, bool wants_parts) const {
  Endurance endurance;
  for (Asking asking{.wants_more = wants_parts ? 1 : 0};;) {
    MPI_Send(&asking, kAskingNumbers, MPI_INT, 0, kAskTag, MPI_COMM_WORLD);
    asking.part = receive_part();
    if (asking.part == kNoPart) return;
    const PartOutcome outcome = make(static_cast<std::uint32_t>(asking.part));
    asking.outcome = static_cast<int>(outcome);
    asking.wants_more = endurance.goes_on(outcome) ? 1 : 0;
  }
}

}  // namespace plait::mpi
