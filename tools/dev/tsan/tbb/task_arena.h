// See plain_threads.h.
#pragma once

#include <tbb/plain_threads.h>

#include <utility>

namespace tbb {

class task_arena {
 public:
  explicit task_arena(int max_concurrency) : max_concurrency_(max_concurrency) {}

  template <class Function>
  auto execute(Function&& function) {
    struct Restore {
      int outer = std::exchange(concurrency, 0);
      ~Restore() { concurrency = outer; }
    } restore;
    concurrency = max_concurrency_;
    return std::forward<Function>(function)();
  }
  int max_concurrency() const { return max_concurrency_; }

 private:
  int max_concurrency_;
};

namespace this_task_arena {

inline int max_concurrency() { return concurrency; }

}  // namespace this_task_arena
}  // namespace tbb
