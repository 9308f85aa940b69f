// Calls the kernel of a sweep for the edges of a chunk, from several threads.
#pragma once

#include <tbb/task_arena.h>

#include <optional>

#include "plait/extend/sweep.h"
#include "plait/extend/topology.h"
#include "plait/progress.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Workers take pieces of the chunk from a counter until none is left, so it does not matter how
/// many of them run at the same time. They run on threads of the program, or on those of oneTBB.
class SweepWorkers {
 public:
  /// `parallel_for` may be empty. `pass` must outlive this object, and so must `parallel_for`.
  SweepWorkers(const ParallelFor& parallel_for, const SweepPass& pass, int threads);
  /// Returns when the kernel has worked on all edges from `first` to before `after`. Errors: one
  /// of the exceptions of the kernel, and those of call_workers().
  void run(const SweepView& view, EdgeId first, EdgeId after);

 private:
  const ParallelFor& parallel_for_;
  const SweepPass& pass_;
  int count_;
  std::optional<tbb::task_arena> arena_;
};

PLAIT_END_NAMESPACE
