// tests/support/parallel_loops.h: thread pools as programs have them.
#pragma once

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <atomic>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "plait/progress.h"
#include "support/sanitized.h"

namespace plait::test {

struct NamedLoop {
  std::string name;
  ParallelFor loop;
  bool by_caller;  ///< the calling thread may run bodies
};

/// `threads` other threads take bodies from a counter. The calling thread only waits.
inline ParallelFor by_other_threads(int threads) {
  return [threads](int count, const std::function<void(int)>& body) {
    std::atomic<int> next = 0;
    std::vector<std::jthread> pool;
    for (int i = 0; i < threads; ++i)
      pool.emplace_back([&] {
        for (int number = next++; number < count; number = next++) body(number);
      });
  };
}

inline std::vector<NamedLoop> parallel_loops() {
  std::vector<NamedLoop> loops = {{"three other threads", by_other_threads(3), false}};
  if (unless_sanitized(true, false)) {
    loops.push_back({"one other thread", by_other_threads(1), false});
    loops.push_back({"a thread for each body", by_other_threads(8), false});
  }
  loops.push_back({"inline, from the last body to the first",
                   [](int count, const std::function<void(int)>& body) {
                     for (int number = count; number-- > 0;) body(number);
                   },
                   true});
  loops.push_back({"oneTBB",
                   [arena = std::make_shared<tbb::task_arena>(2)](
                       int count, const std::function<void(int)>& body) {
                     arena->execute([&] { tbb::parallel_for(0, count, body); });
                   },
                   true});
  return loops;
}

}  // namespace plait::test
