// liburing maps its queues with system calls that the thread sanitizer does not see. If a ring gets
// the addresses of an earlier ring, the sanitizer would report a race between them. The kernel
// orders the end of the earlier ring before the beginning of the later one. These functions tell
// the sanitizer so.
#pragma once

#include_next <liburing.h>

extern "C" void AnnotateHappensBefore(const char* file, int line, const volatile void* event);
extern "C" void AnnotateHappensAfter(const char* file, int line, const volatile void* event);

namespace plait_ordered {

inline char mapping;

inline int io_uring_queue_init(unsigned entries, io_uring* ring, unsigned flags) {
  const int result = ::io_uring_queue_init(entries, ring, flags);
  AnnotateHappensAfter(__FILE__, __LINE__, &mapping);
  return result;
}

inline void io_uring_queue_exit(io_uring* ring) {
  AnnotateHappensBefore(__FILE__, __LINE__, &mapping);
  ::io_uring_queue_exit(ring);
}

}  // namespace plait_ordered

#define io_uring_queue_init plait_ordered::io_uring_queue_init
#define io_uring_queue_exit plait_ordered::io_uring_queue_exit
