// A program that sets no masks of its own: its signals are its threads' alone, however the library
// computes, and the thread that calls the library takes them while it computes.
#include <pthread.h>
#include <unistd.h>

#include <atomic>
#include <catch2/catch.hpp>
#include <cerrno>
#include <csignal>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <stdexcept>
#include <string>
#include <utility>

#include "base/threads.h"
#include "plait/digest.h"
#include "plait/error.h"
#include "plait/extend/import_mesh.h"
#include "plait/layout.h"
#include "plait/mesh_io.h"
#include "plait/registry.h"
#include "plait/store.h"
#include "plait/subdivide.h"
#include "plait/verify.h"
#include "support/answering_operations.h"
#include "support/temporary_directory.h"
#include "support/test_meshes.h"
#include "support/usable_backends.h"

namespace plait::test {
namespace {

constexpr bool is_of_a_fault(int number) {
  return number == SIGSEGV || number == SIGBUS || number == SIGFPE || number == SIGILL ||
         number == SIGTRAP || number == SIGSYS || number == SIGABRT;
}

/// Signals that the C library allows a thread to block, one bit each, as /proc shows them.
std::uint64_t all_but_faults() {
  std::uint64_t bits = 0;
  for (int number = 1; number <= SIGRTMAX; ++number)
    if (!is_of_a_fault(number) && number != SIGKILL && number != SIGSTOP &&
        (number < 32 || number >= SIGRTMIN))
      bits |= std::uint64_t{1} << (number - 1);
  return bits;
}

/// Checks all threads of the process but the main one. Returns how many there are.
int check_other_threads() {
  int count = 0;
  for (const auto& thread : std::filesystem::directory_iterator("/proc/self/task")) {
    if (thread.path().filename() == std::to_string(::getpid())) continue;
    std::ifstream status(thread.path() / "status");
    for (std::string line; std::getline(status, line);)
      if (line.starts_with("SigBlk:")) {
        CAPTURE(line);
        CHECK((std::stoull(line.substr(7), nullptr, 16) & all_but_faults()) == all_but_faults());
        ++count;
      }
  }
  return count;
}

bool has_mask(const sigset_t& expected) {
  sigset_t now;
  ::pthread_sigmask(SIG_SETMASK, nullptr, &now);
  for (int number = 1; number <= SIGRTMAX; ++number)
    if (sigismember(&now, number) != sigismember(&expected, number)) return false;
  return true;
}

std::atomic<int> taken_count = 0;
extern "C" void count_signal(int) { ++taken_count; }

}  // namespace

TEST_CASE("ThreadsOfAllJobs_InAProgramThatSetsNoMask_BlockItsSignals") {
  sigset_t before;
  ::pthread_sigmask(SIG_SETMASK, nullptr, &before);
  const TemporaryDirectory here;
  Store store =
      Store::create(here.path() / "s",
                    lay_out(BaseMesh::build(random_sphere(3, 300)), LayoutKind::kAutomatic).mesh,
                    {.durability = Durability::kNone}, default_backends());
  add_base_positions(store);
  for (const ExecutorKind executor : {ExecutorKind::kFused, ExecutorKind::kSweep}) {
    subdivide(store, {.executor = executor, .levels = 2, .threads = 4});
    check_other_threads();
  }
  store.commit();
  write_ply(here.path() / "m.ply", random_sphere(4, 500));
  try {
    import_mesh(
        {.mesh = here.path() / "m.ply", .store = here.path() / "i", .weld = 0.0, .threads = 4},
        default_backends());
  } catch (const Error& error) {  // it has no levels, which the import finds out in many threads
    CHECK(error.code() == ErrorCode::kInvalidArgument);
  }
  CHECK(check_other_threads() > 0);
  CHECK(has_mask(before));
}

TEST_CASE("CallingThread_WhileALoopRuns_TakesSignalsAndKeepsItsMask") {
  struct sigaction counting {
  }, old{};
  counting.sa_handler = count_signal;
  REQUIRE(::sigaction(SIGUSR1, &counting, &old) == 0);
  sigset_t before;
  ::pthread_sigmask(SIG_SETMASK, nullptr, &before);
  const pthread_t caller = ::pthread_self();
  int sent = 0, taken_at_once = 0;
  const auto signal_itself = [&](std::size_t) {
    if (::pthread_equal(::pthread_self(), caller) == 0) return;
    const int seen = taken_count;
    ::pthread_kill(caller, SIGUSR1);
    ++sent;
    taken_at_once += taken_count - seen;
  };
  each_on_workers(std::size_t{0}, std::size_t{64}, signal_itself);
  ranges_on_workers(1000, 10, [&](std::size_t first, std::size_t) {
    each_on_workers(std::size_t{0}, std::size_t{2}, [&](std::size_t) { signal_itself(first); });
    signal_itself(first);
  });
  CHECK(sent > 1);
  CHECK(taken_at_once == sent);
  CHECK(has_mask(before));
  CHECK_THROWS_AS(each_on_workers(0, 64, [](int) { throw std::logic_error("of a body"); }),
                  std::logic_error);
  CHECK(has_mask(before));
  ::sigaction(SIGUSR1, &old, nullptr);
}

// libssh2/libssh2#955, apple/foundationdb#14081: a profiler, whose handler lets no call go on.
TEST_CASE("Store_OfAThreadThatIsInterruptedAllTheTime_IsTheSame") {
  const LaidOutMesh mesh =
      lay_out(BaseMesh::build(random_sphere(3, 300)), LayoutKind::kAutomatic).mesh;
  const auto make = [&](const std::filesystem::path& path, const std::string& backend) {
    Store store =
        Store::create(path, mesh, {.backend = backend, .block_bytes = 4096}, default_backends());
    add_base_positions(store);
    subdivide(store, {.executor = ExecutorKind::kSweep, .levels = 4, .threads = 2});
    return store;
  };
  const Digest expected = digest(make({}, "memory"));
  for (const std::string& backend : usable_backends()) {
    if (backend == "memory") continue;
    CAPTURE(backend);
    const TemporaryDirectory here;
    const AnsweringOperations hook([](const FileOperation& operation) {
      constexpr int kInterruptions = 50;
      thread_local int left = kInterruptions;
      if (operation.kind == FileOperation::Kind::kMap ||
          operation.kind == FileOperation::Kind::kClose)
        return 0;
      if (left-- > 0) return EINTR;
      left = kInterruptions;
      return 0;
    });
    bool is_whole = false;
    try {
      Store store = make(here.path() / "s", backend);
      store.commit();
      store.close();
      const Store again = Store::open(here.path() / "s", {}, default_backends());
      is_whole = verify(again).damaged.empty() && digest(again) == expected;
    } catch (const Error& error) {
      UNSCOPED_INFO(error.what());
    }
    CHECK(is_whole);
    CHECK(hook.answers() > 1000);
  }
}

// pybind/pybind11#1208, Ardour/ardour#1125: a thread that ends inside the library, by
// pthread_exit() in a callback.
TEST_CASE("Thread_ThatEndsInItsProgress_LeavesAStoreThatGoesOn") {
  const auto ends = [](const Progress&) -> bool { ::pthread_exit(nullptr); };
  Store store = Store::create({}, BaseMesh::build(random_sphere(3, 100)), {.backend = "memory"},
                              default_backends());
  add_base_positions(store);
  subdivide(store, {.levels = 2});
  store.commit();
  const Digest expected = digest(store);
  bool went_on = false;
  const std::pair<const char*, std::function<void()>> works[] = {
      {"sweep",
       [&] {
         subdivide(store, {.executor = ExecutorKind::kSweep, .levels = 4, .progress = ends});
       }},
      {"sweep in threads",
       [&] {
         subdivide(store,
                   {.executor = ExecutorKind::kSweep, .levels = 4, .threads = 2, .progress = ends});
       }},
      {"digest in threads", [&] { digest(store, {.threads = 2, .progress = ends}); }},
      {"transparent",
       [&] {
         subdivide(store, {.executor = ExecutorKind::kTransparent, .levels = 4, .progress = ends});
       }},
      {"normals", [&] { subdivide(store, {.levels = 2, .normals = true, .progress = ends}); }},
      {"digest", [&] { digest(store, {.progress = ends}); }},
      {"verify", [&] { verify(store, ends); }}};
  for (const auto& [name, work] : works) {
    CAPTURE(name);
    start_thread("a thread", [&, &work = work] {
      work();
      went_on = true;
    }).join();
    CHECK_FALSE(went_on);
    store.roll_back();
    CHECK(digest(store) == expected);
  }
  subdivide(store, {.executor = ExecutorKind::kSweep, .levels = 3, .normals = true});
  store.commit();
}

}  // namespace plait::test
