// render/parallel_rows.h: distributes the rows of a picture over threads.
#pragma once

#include <thread>
#include <vector>

namespace plait {

/// Calls work(row) once for every row in [0, rows). `work` must not throw.
template <class Work>
void parallel_rows(int rows, int threads, Work work) {
  const auto run = [&](int first) {
    for (int row = first; row < rows; row += threads) work(row);
  };
  std::vector<std::jthread> workers;
  for (int worker = 1; worker < threads; ++worker) workers.emplace_back(run, worker);
  run(0);
}

}  // namespace plait
