// The power fails at every operation of a run, and of putting a store back after one.
//
// PLAIT_LONG=1 in the environment tries more outcomes of each.
#include "durability/power_cut.h"

#include <atomic>
#include <catch2/catch.hpp>
#include <cstdlib>

#include "durability/workload.h"
#include "engine/store/sample_store.h"
#include "plait/registry.h"
#include "support/sanitized.h"
#include "support/temporary_directory.h"

namespace plait::test {
namespace {

/// How many versions are committed, and whether one more is on its way.
class Progress final : public CommitObserver {
 public:
  void committing(std::uint64_t version) override { state_ = 2 * version - 1; }
  void committed(std::uint64_t version) override { state_ = 2 * version; }
  std::uint64_t state() const { return state_; }

  static bool allows(std::uint64_t state, std::uint64_t version) {
    return version == state / 2 || (state % 2 == 1 && version == state / 2 + 1);
  }

 private:
  std::atomic<std::uint64_t> state_ = 0;
};

int outcomes_per_operation() { return std::getenv("PLAIT_LONG") ? 40 : unless_sanitized(4, 1); }

}  // namespace

TEST_CASE("PowerCut_AtEveryOperationOfARun_LeavesTheLastCommitOrTheOneInFlight") {
  for (const std::string& backend : durable_backends()) {
    const TemporaryDirectory undisturbed(Medium::kMemory), run(Medium::kMemory),
        after(Medium::kMemory);
    const auto versions = digests_of_undisturbed_run(undisturbed.path() / "s.plait", backend);
    Progress progress;
    std::vector<PowerCut::Outcome> found;
    {
      PowerCut cut(run.path(), 1, outcomes_per_operation(), [&] { return progress.state(); });
      run_workload(run.path() / "s.plait", backend, progress);
      found = cut.outcomes();
    }
    CHECK(version_found(run.path() / "s.plait", versions) == versions.size() - 1);
    CAPTURE(backend);
    REQUIRE(found.size() > 50);
    for (const PowerCut::Outcome& outcome : found) {
      CAPTURE(outcome.operation, outcome.note);
      outcome.put_into(after.path());
      const std::uint64_t version = version_found(after.path() / "s.plait", versions);
      if (!Progress::allows(outcome.note, version)) CHECK(version == outcome.note / 2);
    }
  }
}

TEST_CASE("PowerCut_WhileAWriterOpensAfterARunWithoutCommit_LeavesTheLastCommit") {
  for (const std::string& backend : durable_backends()) {
    const TemporaryDirectory run(Medium::kMemory), after(Medium::kMemory);
    const std::filesystem::path store = run.path() / "s.plait";
    Progress progress;
    const auto versions = [&] {
      const TemporaryDirectory undisturbed(Medium::kMemory);
      return digests_of_undisturbed_run(undisturbed.path() / "s.plait", backend);
    }();
    // Ends with changes that were never committed.
    {
      const NoWaiting no_waiting;
      run_workload(store, backend, progress);
    }
    std::vector<PowerCut::Outcome> found;
    {
      PowerCut cut(run.path(), 2, outcomes_per_operation(), [] { return 0; });
      const Store opened = Store::open(store, {true}, default_backends());
      found = cut.outcomes();
    }
    CAPTURE(backend);
    REQUIRE_FALSE(found.empty());
    for (const PowerCut::Outcome& outcome : found) {
      CAPTURE(outcome.operation);
      outcome.put_into(after.path());
      CHECK(version_found(after.path() / "s.plait", versions) == versions.size() - 1);
    }
  }
}

}  // namespace plait::test
