// base/run_workers.h: several workers do one work, on threads of the program or on new ones.
#pragma once

#include <functional>
#include <string_view>

#include "plait/progress.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// A work whose workers take what they do from a queue until none is left.
struct SharedWork {
  /// Called once for each worker. It calls `report` between two steps. May throw.
  std::function<void(int worker, const std::function<void()>& report)> work;
  /// Reports progress, and may throw. The calling thread calls it, or any thread of the program's
  /// pool, one at a time.
  std::function<void()> report;
  /// Called after an error, by any thread: empties the queue.
  std::function<void()> stop;
};

/// Does the work by `count` workers: by `parallel_for`, unless it is empty, or by the calling
/// thread and new threads. `name` is for messages. Throws the first error of any worker, when all
/// have ended, but rather one that is no refusal (kBadState). Errors: also kOutOfMemory for a
/// thread that cannot be started; those of call_workers().
void run_workers(const ParallelFor& parallel_for, int count, std::string_view name,
                 const SharedWork& shared);

PLAIT_END_NAMESPACE
