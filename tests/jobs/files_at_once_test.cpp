// Many calls at once: each index once, the first error, and an end where the system allows no
// further thread.
#include "parts/files_at_once.h"

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <cstddef>
#include <cstdint>
#include <fstream>
#include <stdexcept>
#include <string>
#include <system_error>
#include <thread>
#include <vector>

#include "plait/error.h"
#include "support/sanitized.h"
#include "support/skip.h"

namespace plait::test {
namespace {

using Calls = std::vector<std::atomic<int>>;

bool each_was_called_once(const Calls& calls) {
  return std::ranges::all_of(calls, [](const std::atomic<int>& count) { return count == 1; });
}

TEST_CASE("EachFileAtOnce_AnyNumber_CallsEachOnceAndTellsHowMany", "[threads]") {
  for (const std::size_t count : {0u, 1u, 2u, 31u, 33u, 1000u}) {
    INFO(count);
    Calls calls(count);
    std::size_t told = 0;
    const std::thread::id here = std::this_thread::get_id();
    each_file_at_once(
        count, "a test", [&](std::size_t at) { ++calls[at]; },
        [&](std::size_t begun) {
          if (std::this_thread::get_id() != here || begun < told || begun > count)
            throw std::logic_error("expected a count that grows, from the calling thread");
          told = begun;
        });
    CHECK(each_was_called_once(calls));
  }
}

TEST_CASE("EachFileAtOnce_CallsThatWaitForEachOther_AreThereAtTheSameTime", "[threads]") {
  constexpr int kTogether = 8;
  std::atomic<int> waiting = 0;
  each_file_at_once(kTogether, "a test",
                    [&](std::size_t) {
                      ++waiting;
                      for (int seen = waiting; seen < kTogether; seen = waiting) waiting.wait(seen);
                      waiting.notify_all();
                    },
                    {});
  CHECK(waiting == kTogether);
}

TEST_CASE("EachFileAtOnce_AnError_EndsTheOthersAndIsThrown", "[threads]") {
  std::atomic<int> calls = 0;
  const auto fail = [&](std::size_t at) {
    ++calls;
    if (at == 20) throw Error(ErrorCode::kOutOfMemory, "the memory of call 20");
  };
  try {
    each_file_at_once(100'000, "a test", fail, {});
    FAIL("expected an error");
  } catch (const Error& error) {
    CHECK(error.what() == std::string("the memory of call 20"));
  }
  CHECK(calls < 100'000);
  const auto cancel = [](std::size_t) { throw Error(ErrorCode::kCancelled, "cancelled"); };
  CHECK_THROWS_AS(each_file_at_once(
                      100, "a test", [](std::size_t) {}, cancel),
                  Error);
}

/// In a child process that has no address space for the stacks of more threads.
int calls_without_threads() {
  std::uint64_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  const rlim_t limit =
      pages * static_cast<rlim_t>(::sysconf(_SC_PAGESIZE)) + (std::size_t{2} << 20);
  const rlimit limits = {limit, limit};
  if (::setrlimit(RLIMIT_AS, &limits) != 0) return 1;
  // Stacks of threads that have ended would do for a few.
  bool is_refused = false;
  for (int started = 0; started < 1000 && !is_refused; ++started) try {
      std::thread([] { ::pause(); }).detach();
    } catch (const std::system_error&) {
      is_refused = true;
    }
  if (!is_refused) return 2;
  Calls calls(1000);
  each_file_at_once(calls.size(), "a test", [&](std::size_t at) { ++calls[at]; }, {});
  return each_was_called_once(calls) ? 0 : 3;
}

TEST_CASE("EachFileAtOnce_NoFurtherThread_CallsEachOnceAllTheSame", "[threads]") {
  if (unless_sanitized(false, true)) {
    skip("address space cannot be limited under a sanitizer");
    return;
  }
  const pid_t child = ::fork();
  REQUIRE(child >= 0);
  if (child == 0) {
    try {
      ::_exit(calls_without_threads());
    } catch (...) {
      ::_exit(4);
    }
  }
  int status = 0;
  REQUIRE(::waitpid(child, &status, 0) == child);
  REQUIRE(WIFEXITED(status));
  CHECK(WEXITSTATUS(status) == 0);
}

}  // namespace
}  // namespace plait::test
