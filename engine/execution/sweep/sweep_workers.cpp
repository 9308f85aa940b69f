#include "execution/sweep/sweep_workers.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cstdint>

#include "base/default_arithmetic.h"
#include "base/threads.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

SweepWorkers::SweepWorkers(const ParallelFor& parallel_for, const SweepPass& pass, int threads)
    : parallel_for_(parallel_for), pass_(pass), count_(threads) {
  if (parallel_for_) return;
  // At most the number of threads that the machine can run at once: TBB would print a warning and
  // ignore the others.
  count_ = std::min(threads, tbb::this_task_arena::max_concurrency());
  if (count_ > 1) arena_.emplace(count_);
}

void SweepWorkers::run(const SweepView& view, EdgeId first, EdgeId after) {
  // Few enough that the counter costs nothing, and enough that no worker waits long for the last.
  constexpr std::uint64_t kPiecesOfWorker = 16;
  const std::uint64_t pieces = kPiecesOfWorker * static_cast<std::uint64_t>(count_);
  const std::uint64_t piece = std::max<std::uint64_t>(1, (after - first) / pieces);
  std::atomic<std::uint64_t> next = first;
  const auto work = [&](int worker) {
    const DefaultArithmetic arithmetic;
    try {
      for (std::uint64_t at = next.fetch_add(piece); at < after; at = next.fetch_add(piece)) {
        const auto end = static_cast<EdgeId>(std::min<std::uint64_t>(after, at + piece));
        for (auto edge = static_cast<EdgeId>(at); edge < end; ++edge)
          pass_.kernel(view, edge, worker);
      }
    } catch (...) {
      next = after;  // the others stop
      throw;
    }
  };
  if (count_ == 1)
    work(0);
  else if (parallel_for_)
    call_workers(parallel_for_, count_, fmt::format("sweep '{}'", pass_.name), work);
  else
    arena_->execute([&] { each_on_workers(0, count_, work); });
}

PLAIT_END_NAMESPACE
