// tools/tune/thread_time.h: the processor time of a thread.
#pragma once

#include <time.h>

namespace plait::tune {

/// The processor time of this thread, which other programs do not lengthen as they do the time that
/// passes.
inline double thread_seconds() {
  timespec time{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

}  // namespace plait::tune
