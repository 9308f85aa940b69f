// Plans and refinements of a base mesh in files take no more memory than they are given, whatever
// the mesh has.
#include <catch2/catch.hpp>
#include <cstdint>
#include <string>

#include "support/resource_limit.h"
#include "support/skip.h"
#include "workplace.h"

namespace plait::test {
namespace {

constexpr std::uint64_t kMebibyte = 1 << 20;

}  // namespace

TEST_CASE("PlanMemory_OfALargerBaseMesh_IsThatOfTheOption") {
  if (!kAddressSpaceCanBeLimited) {
    skip("sanitizers have memory of their own");
    return;
  }
  const Workplace here;
  here.succeed({"generate", "torus", "large.ply", "--vertices", "800000"});
  here.succeed({"layout", "large.ply", "large.base", "--memory", "256M"});
  const auto plan = [&](const std::string& name, const std::string& memory) {
    return here.report(
        {"plan", "large.base", name, "--levels", "1", "--parts", "64", "--memory", memory});
  };
  const nlohmann::json whole = plan("whole.plan", "1G"), ranges = plan("ranges.plan", "96M");
  CHECK(ranges["parts"] == whole["parts"]);
  CHECK(ranges["memory"] == whole["memory"]);
  // The arrays have 101 MiB, without what a plan computes of them.
  CHECK(whole["peak_rss_bytes"] > 96 * kMebibyte);
  CHECK(ranges["peak_rss_bytes"] < 96 * kMebibyte);
  const Outcome few = here.plait({"plan", "large.base", "few.plan", "--levels", "1", "--parts", "2",
                                  "--memory", "96M", "--json"});
  CHECK(few.status == 1);
  CHECK(few.json()["error"]["code"] == "budget");
}

TEST_CASE("SubdivideMemory_OfABaseMeshOfTenTimesTheLimit_IsTheLimitAndTheProgram") {
  if (!kAddressSpaceCanBeLimited) {
    skip("sanitizers have memory of their own");
    return;
  }
  const Workplace here;
  // 4 million faces. The arrays have 264 MB.
  here.succeed({"generate", "torus", "large.ply", "--vertices", "2000000"});
  here.succeed({"layout", "large.ply", "large.base", "--memory", "512M"});
  const auto subdivide = [&](const std::string& name, const std::string& memory) {
    return here.report({"subdivide", "large.base", name, "--levels", "1", "--normals", "--backend",
                        "pread", "--memory", memory, "--durability", "none"});
  };
  const nlohmann::json pieces = subdivide("pieces.plait", "24M"),
                       whole = subdivide("whole.plait", "512M");
  CHECK(pieces["piece_bytes"] == 12 * kMebibyte);
  CHECK(whole["piece_bytes"] == 0);
  CHECK(whole["peak_rss_bytes"] > 264'000'000);
  CHECK(pieces["peak_rss_bytes"] < (24 + 32) * kMebibyte);
  CHECK(here.digest("pieces.plait") == here.digest("whole.plait"));
}

}  // namespace plait::test
