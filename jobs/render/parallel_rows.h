// render/parallel_rows.h: distributes the rows of a picture over threads.
#pragma once

#include <atomic>
#include <functional>

#include "base/run_workers.h"
#include "plait/progress.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Who computes the rows of a picture.
struct RowWorkers {
  const ParallelFor& parallel_for;  ///< of the program; may be empty
  int threads = 1;
  std::function<void()> report = [] {};  ///< called between rows; may throw
};

/// Calls work(row) once for every row in [0, rows). Errors: as run_workers().
template <class Work>
void parallel_rows(int rows, const RowWorkers& workers, const Work& work) {
  std::atomic<int> next = 0;
  const auto work_on_rows = [&](int, const std::function<void()>& report) {
    for (int row = next++; row < rows; row = next++) {
      work(row);
      report();
    }
  };
  run_workers(workers.parallel_for, workers.threads, "render",
              {.work = work_on_rows, .report = workers.report, .stop = [&] { next = rows; }});
}

PLAIT_END_NAMESPACE
