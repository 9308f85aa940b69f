#include "instrument/surroundings.h"

#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <ctime>

namespace plait::instrument {
namespace {

/// Takes so much processor time.
void compute_for(double seconds) {
  const std::clock_t start = std::clock();
  while (static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC < seconds) {
  }
}

}  // namespace

TEST_CASE("a busy process beside a measurement is seen, and what is measured is not") {
  // The same work, once as that of another program and once as that of the measured one.
  const SurroundingsWatch watch;
  const pid_t child = ::fork();
  if (child == 0) {
    compute_for(0.5);
    ::_exit(0);
  }
  ::waitpid(child, nullptr, 0);
  const Surroundings as_other = watch.since(0);
  const Surroundings as_own = watch.since(1000);
  CHECK(as_other.others > 0);
  CHECK(as_own.others == 0);
  CHECK(as_other.disturbance() >= as_other.others);
  CHECK(as_other.disturbance() <= 1.01);
  CHECK(to_json(as_other)["others"] == as_other.others);
}

}  // namespace plait::instrument
