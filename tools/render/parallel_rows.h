// render/parallel_rows.h: distributes the rows of a picture over threads.
#pragma once

#include <fmt/format.h>

#include "base/threads.h"

namespace plait {

/// Calls work(row) once for every row in [0, rows). `work` must not throw.
template <class Work>
void parallel_rows(int rows, int threads, Work work) {
  const auto run = [&](int first) {
    for (int row = first; row < rows; row += threads) work(row);
  };
  JoinedThreads workers;
  for (int worker = 1; worker < threads; ++worker)
    workers.start(fmt::format("thread {} of {}", worker + 1, threads),
                  [&, worker] { run(worker); });
  run(0);
}

}  // namespace plait
