// See plain_threads.h.
#pragma once

#include <tbb/blocked_range.h>
#include <tbb/plain_threads.h>

namespace tbb {

template <class Index, class Body>
void parallel_for(Index first, Index last, const Body& body) {
  if (!(first < last)) return;
  call_for_all(static_cast<std::size_t>(last - first),
               [&](std::size_t i) { body(static_cast<Index>(first + static_cast<Index>(i))); });
}

/// Divides the range into ranges of one grain each, the smallest that TBB may make.
template <class Value, class Body>
void parallel_for(const blocked_range<Value>& range, const Body& body) {
  if (range.empty()) return;
  const std::size_t grain = range.grainsize();
  call_for_all((range.size() + grain - 1) / grain, [&](std::size_t piece) {
    const std::size_t first = piece * grain, last = std::min(range.size(), first + grain);
    body(blocked_range<Value>(static_cast<Value>(range.begin() + static_cast<Value>(first)),
                              static_cast<Value>(range.begin() + static_cast<Value>(last)), grain));
  });
}

}  // namespace tbb
