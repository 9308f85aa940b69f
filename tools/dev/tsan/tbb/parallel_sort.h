// See plain_threads.h. Sorts on one thread, because sorting has no race to detect.
#pragma once

#include <algorithm>

namespace tbb {

template <class Iterator>
void parallel_sort(Iterator first, Iterator last) {
  std::sort(first, last);
}

}  // namespace tbb
