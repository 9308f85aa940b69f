// bench/instrument/in_threads.h: the same work on several threads.
#pragma once

#include <cstddef>
#include <future>
#include <vector>

namespace plait::instrument {

/// Calls work(0) to work(count - 1), each on a thread of its own, and throws an error of one of
/// them when all have ended.
template <class Work>
void in_threads(int count, Work work) {
  std::vector<std::future<void>> running;
  for (std::size_t thread = 0; thread < static_cast<std::size_t>(count); ++thread)
    running.push_back(std::async(std::launch::async, [&work, thread] { work(thread); }));
  // If one throws, the destructors of the others wait for them.
  for (std::future<void>& one : running) one.get();
}

}  // namespace plait::instrument
