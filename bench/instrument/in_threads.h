// bench/instrument/in_threads.h: the same work on several threads.
#pragma once

#include <cstddef>
#include <exception>
#include <thread>
#include <vector>

namespace plait::instrument {

/// Calls work(0) to work(count - 1), each on a thread of its own, and throws an error of one of
/// them when all have ended.
template <class Work>
void in_threads(int count, Work work) {
  std::vector<std::exception_ptr> failures(static_cast<std::size_t>(count));
  {
    std::vector<std::jthread> threads;
    for (std::size_t thread = 0; thread < failures.size(); ++thread)
      threads.emplace_back([&, thread] {
        try {
          work(thread);
        } catch (...) {
          failures[thread] = std::current_exception();
        }
      });
  }
  for (const std::exception_ptr& failure : failures)
    if (failure) std::rethrow_exception(failure);
}

}  // namespace plait::instrument
