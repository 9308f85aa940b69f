#include "micro/counted_locks.h"

#include <dlfcn.h>
#include <pthread.h>
#include <time.h>

#include <array>
#include <atomic>
#include <cstddef>

namespace plait::bench {
namespace {

/// Of one thread, or of several if there are more than kThreads.
struct alignas(64) Counts {
  std::atomic<std::uint64_t> locked, contended, waited_ns, held_ns, slept_ns;
};
constexpr std::size_t kThreads = 1024;
constinit std::array<Counts, kThreads> counts{};
constinit std::atomic<std::size_t> next_thread = 0;

Counts& mine() {
  thread_local const std::size_t number = next_thread++ % kThreads;
  return counts[number];
}

void add(std::atomic<std::uint64_t>& to, std::uint64_t value) {
  to.fetch_add(value, std::memory_order_relaxed);
}

std::uint64_t now_ns() {
  timespec time{};
  ::clock_gettime(CLOCK_MONOTONIC, &time);
  return static_cast<std::uint64_t>(time.tv_sec) * 1'000'000'000 +
         static_cast<std::uint64_t>(time.tv_nsec);
}

/// The mutexes that this thread has, and since when. What is beyond the last place is not timed.
struct Held {
  const pthread_mutex_t* mutex;
  std::uint64_t since;
};
constinit thread_local std::array<Held, 8> held{};

void got(const pthread_mutex_t* mutex) {
  for (Held& each : held)
    if (each.mutex == nullptr) {
      each = {mutex, now_ns()};
      return;
    }
}

void gives_back(const pthread_mutex_t* mutex) {
  for (Held& each : held)
    if (each.mutex == mutex) {
      add(mine().held_ns, now_ns() - each.since);
      each.mutex = nullptr;
      return;
    }
}

/// The function of this name in the C library.
template <class Function>
Function* in_libc(std::atomic<Function*>& found, const char* name) {
  Function* function = found.load(std::memory_order_relaxed);
  if (function == nullptr) {
    function = reinterpret_cast<Function*>(::dlsym(RTLD_NEXT, name));
    found.store(function, std::memory_order_relaxed);
  }
  return function;
}

template <class Wait>
int sleep_without(pthread_mutex_t* mutex, Wait wait) {
  gives_back(mutex);
  const std::uint64_t start = now_ns();
  const int result = wait();
  add(mine().slept_ns, now_ns() - start);
  got(mutex);
  return result;
}

}  // namespace

LockCounts take_lock_counts() {
  LockCounts sum;
  for (Counts& each : counts) {
    sum.locked += each.locked.exchange(0);
    sum.contended += each.contended.exchange(0);
    sum.waited_ns += each.waited_ns.exchange(0);
    sum.held_ns += each.held_ns.exchange(0);
    sum.slept_ns += each.slept_ns.exchange(0);
  }
  return sum;
}

}  // namespace plait::bench

// The names are those of POSIX, and the linker takes these functions before those of the C library.
// NOLINTBEGIN(readability-inconsistent-declaration-parameter-name): the C library's are reserved
extern "C" {

int pthread_mutex_trylock(pthread_mutex_t* mutex) noexcept {
  using namespace plait::bench;
  static constinit std::atomic<int (*)(pthread_mutex_t*)> found = nullptr;
  const int result = in_libc(found, "pthread_mutex_trylock")(mutex);
  if (result == 0) {
    add(mine().locked, 1);
    got(mutex);
  }
  return result;
}

int pthread_mutex_lock(pthread_mutex_t* mutex) noexcept {
  using namespace plait::bench;
  static constinit std::atomic<int (*)(pthread_mutex_t*)> found = nullptr;
  if (pthread_mutex_trylock(mutex) == 0) return 0;
  const std::uint64_t start = now_ns();
  const int result = in_libc(found, "pthread_mutex_lock")(mutex);
  if (result != 0) return result;
  add(mine().waited_ns, now_ns() - start);
  add(mine().contended, 1);
  add(mine().locked, 1);
  got(mutex);
  return 0;
}

int pthread_mutex_unlock(pthread_mutex_t* mutex) noexcept {
  using namespace plait::bench;
  static constinit std::atomic<int (*)(pthread_mutex_t*)> found = nullptr;
  gives_back(mutex);
  return in_libc(found, "pthread_mutex_unlock")(mutex);
}

int pthread_cond_wait(pthread_cond_t* condition, pthread_mutex_t* mutex) {
  using namespace plait::bench;
  static constinit std::atomic<int (*)(pthread_cond_t*, pthread_mutex_t*)> found = nullptr;
  return sleep_without(mutex,
                       [&] { return in_libc(found, "pthread_cond_wait")(condition, mutex); });
}

int pthread_cond_clockwait(pthread_cond_t* condition, pthread_mutex_t* mutex, clockid_t clock,
                           const timespec* until) {
  using namespace plait::bench;
  static constinit std::atomic<int (*)(pthread_cond_t*, pthread_mutex_t*, clockid_t,
                                       const timespec*)>
      found = nullptr;
  return sleep_without(mutex, [&] {
    return in_libc(found, "pthread_cond_clockwait")(condition, mutex, clock, until);
  });
}

}  // extern "C"
// NOLINTEND(readability-inconsistent-declaration-parameter-name)
