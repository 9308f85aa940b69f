// surface/paced_ranges.h: long loops that ask now and then whether they shall go on.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>

#include "plait/detail/namespace.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// The sizes of the ranges of for_paced_ranges().
struct Pace {
  std::size_t fewest = 1, most = static_cast<std::size_t>(-1);
};

/// Calls go_on(first), then work(first, last), for ranges that follow each other and cover
/// [0, count). A range takes about 50 ms, if its size allows, so what go_on() throws ends the loop
/// soon, and the calls cost nothing.
template <class GoOn, class Work>
void for_paced_ranges(std::size_t count, Pace pace, const GoOn& go_on, const Work& work) {
  constexpr std::chrono::milliseconds kBetweenCalls(50);
  std::size_t at_once = pace.fewest;
  for (std::size_t first = 0; first < count;) {
    go_on(first);
    const auto begin = std::chrono::steady_clock::now();
    const std::size_t last = first + std::min(at_once, count - first);
    work(first, last);
    first = last;
    const bool fast = std::chrono::steady_clock::now() - begin < kBetweenCalls;
    at_once = fast ? (at_once > pace.most / 2 ? pace.most : 2 * at_once)
                   : std::max(at_once / 2, pace.fewest);
  }
}

PLAIT_END_NAMESPACE
