// tests/fuzz/bounded_work.h: a decoder's memory follows from the geometry of its level, and no
// input takes more than ten times as long as an honest one.
#pragma once

#include <time.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>

#include "oracle.h"

#if defined(__has_feature)
#if __has_feature(address_sanitizer)
#define PLAIT_COUNTS_MEMORY 1
#endif
#endif
#if defined(__SANITIZE_ADDRESS__)
#define PLAIT_COUNTS_MEMORY 1
#endif
#ifdef PLAIT_COUNTS_MEMORY
// GCC has the function, and not the header that declares it.
extern "C" int __sanitizer_install_malloc_and_free_hooks(void (*malloc_hook)(const volatile void*,
                                                                             std::size_t),
                                                         void (*free_hook)(const volatile void*));
#endif

namespace plait::fuzz {

/// Bytes that this thread has allocated so far, freed ones included. The address sanitizer counts
/// them; without it the result is 0.
inline thread_local std::uint64_t allocated_bytes = 0;

inline void count_allocations() {
#ifdef PLAIT_COUNTS_MEMORY
  static const bool counts =
      __sanitizer_install_malloc_and_free_hooks(
          [](const volatile void*, std::size_t size) { allocated_bytes += size; },
          [](const volatile void*) {}) > 0;
  static_cast<void>(counts);
#endif
}

/// Ends the program if `call` allocates more than `most_bytes`, with room for an error message.
template <class Call>
void require_memory(std::uint64_t most_bytes, Call call) {
  constexpr std::uint64_t kMessageBytes = 16 << 10;
  count_allocations();
  const std::uint64_t before = allocated_bytes;
  call();
  const std::uint64_t used = allocated_bytes - before;
  if (used <= most_bytes + kMessageBytes) return;
  std::fprintf(stderr, "allocated %llu bytes, expected at most %llu\n",
               static_cast<unsigned long long>(used),
               static_cast<unsigned long long>(most_bytes + kMessageBytes));
  require(false);
}

/// The least processor time of some calls, in seconds.
template <class Call>
double fastest(int calls, Call call) {
  const auto now = [] {
    timespec time{};
    ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
    return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
  };
  double least = 1e9;
  for (int i = 0; i < calls; ++i) {
    const double start = now();
    call();
    least = std::min(least, now() - start);
  }
  return least;
}

/// Runs `call`, and ends the program if that takes more than ten times `honest_seconds`. Only if
/// the environment has PLAIT_FUZZ_TIMES: tests do not depend on times.
template <class Call>
void require_time(double honest_seconds, Call call) {
  static const bool counts = std::getenv("PLAIT_FUZZ_TIMES") != nullptr;
  if (!counts) return static_cast<void>(call());
  // An error is thrown, caught and put into words in less.
  constexpr double kMessageSeconds = 1e-4;
  constexpr int kTries = 20;
  const double most = 10 * honest_seconds + kMessageSeconds;
  if (fastest(1, call) <= most) return;
  const double seconds = fastest(kTries, call);
  if (seconds <= most) return;
  std::fprintf(stderr, "took %g us, an honest input takes %g us\n", 1e6 * seconds,
               1e6 * honest_seconds);
  require(false);
}

}  // namespace plait::fuzz
