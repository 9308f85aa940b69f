// A plan of a base mesh in files takes no more memory than it is given, whatever the mesh has.
#include <catch2/catch.hpp>
#include <cstdint>
#include <string>
#include <vector>

#include "program.h"
#include "support/resource_limit.h"
#include "support/skip.h"

namespace plait::test {

TEST_CASE("PlanMemory_OfALargerBaseMesh_IsThatOfTheOption") {
  if (!kAddressSpaceCanBeLimited) {
    skip("sanitizers have memory of their own");
    return;
  }
  using Names = std::vector<std::string>;
  constexpr std::uint64_t kMebibyte = 1 << 20;
  const TemporaryDirectory here;
  const auto succeed = [&](const Names& arguments) {
    Outcome outcome = run(here.path(), arguments);
    CAPTURE(arguments, outcome.errors);
    REQUIRE(outcome.status == 0);
    return outcome;
  };
  succeed({"generate", "torus", "large.ply", "--vertices", "800000"});
  succeed({"layout", "large.ply", "large.base", "--memory", "256M"});
  const auto plan = [&](const std::string& name, const std::string& memory) {
    return succeed({"plan", "large.base", name, "--levels", "1", "--parts", "64", "--memory",
                    memory, "--json"})
        .json();
  };
  const nlohmann::json whole = plan("whole.plan", "1G"), ranges = plan("ranges.plan", "96M");
  CHECK(ranges["parts"] == whole["parts"]);
  CHECK(ranges["memory"] == whole["memory"]);
  // The arrays have 101 MiB, without what a plan computes of them.
  CHECK(whole["peak_rss_bytes"] > 96 * kMebibyte);
  CHECK(ranges["peak_rss_bytes"] < 96 * kMebibyte);
  const Outcome few = run(here.path(), {"plan", "large.base", "few.plan", "--levels", "1",
                                        "--parts", "2", "--memory", "96M", "--json"});
  CHECK(few.status == 1);
  CHECK(few.json()["error"]["code"] == "budget");
}

}  // namespace plait::test
