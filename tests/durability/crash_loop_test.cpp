// Processes killed at random instants of a run of everything that a store does lose nothing that
// was committed. What the program does: tests/tools/kill_test.cpp.
//
// PLAIT_LONG=1 in the environment kills more than 1,000 times.
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <catch2/catch.hpp>
#include <chrono>
#include <cstdlib>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "durability/faults.h"
#include "durability/workload.h"
#include "engine/store/sample_store.h"
#include "support/computing.h"
#include "support/temporary_directory.h"

namespace plait::test {
namespace {

int kills(int short_run) { return std::getenv("PLAIT_LONG") ? 16 * short_run : short_run; }

/// Tells another process how far it is, a byte each time.
class ToldThroughAPipe final : public CommitObserver {
 public:
  explicit ToldThroughAPipe(int descriptor) : descriptor_(descriptor) {}
  void committing(std::uint64_t version) override { tell(2 * version - 1); }
  void committed(std::uint64_t version) override { tell(2 * version); }

 private:
  void tell(std::uint64_t state) const {
    const auto byte = static_cast<unsigned char>(state);
    if (::write(descriptor_, &byte, 1) != 1) ::_exit(2);
  }

  int descriptor_;
};

/// Runs the workload in a process that is killed when it has computed for `lifetime`, unless it
/// ends before. The last it told (`waits`: for the disk, at every sync): 2 v for version v
/// committed, one less for one on its way.
std::uint64_t state_when_killed(const std::filesystem::path& store, const std::string& backend,
                                std::chrono::microseconds lifetime, bool waits) {
  std::array<int, 2> pipe{};
  REQUIRE(::pipe(pipe.data()) == 0);
  const pid_t child = ::fork();
  REQUIRE(child >= 0);
  if (child == 0) {
    ::close(pipe[0]);
    ToldThroughAPipe observer(pipe[1]);
    try {
      std::optional<NoWaiting> no_waiting;
      if (!waits) no_waiting.emplace();
      run_workload(store, backend, observer);
    } catch (...) {
      ::_exit(3);
    }
    ::_exit(0);
  }
  ::close(pipe[1]);
  computes_for(child, lifetime);
  ::kill(child, SIGKILL);
  int status = 0;
  ::waitpid(child, &status, 0);
  CHECK((WIFSIGNALED(status) || WEXITSTATUS(status) == 0));
  unsigned char state = 0, next = 0;
  while (::read(pipe[0], &next, 1) == 1) state = next;
  ::close(pipe[0]);
  return state;
}

}  // namespace

TEST_CASE("Kill_AtAnyInstantOfARun_LeavesTheLastCommitOrTheOneInFlight") {
  std::mt19937_64 random(7);
  for (const std::string& backend : durable_backends()) {
    const TemporaryDirectory undisturbed;
    const auto versions = digests_of_undisturbed_run(undisturbed.path() / "s.plait", backend);
    std::uint64_t longest_us = 20000;
    for (int kill = 0; kill < kills(16); ++kill) {
      const TemporaryDirectory here;
      const std::uint64_t lifetime_us = random() % longest_us;
      const std::uint64_t state = state_when_killed(
          here.path() / "s.plait", backend, std::chrono::microseconds(lifetime_us), kill % 4 == 0);
      CAPTURE(backend, kill, state, lifetime_us);
      const std::uint64_t version = version_found(here.path() / "s.plait", versions);
      CHECK((version == state / 2 || (state % 2 == 1 && version == state / 2 + 1)));
      // Until lifetimes cover the whole run, however fast the machine.
      if (state < 2 * (versions.size() - 1)) longest_us += longest_us / 8;
    }
  }
}

}  // namespace plait::test
