// A base mesh in files whose arrays are ten times the memory limit is refined within it.
#include <catch2/catch.hpp>
#include <cstdint>
#include <string>
#include <vector>

#include "program.h"
#include "support/resource_limit.h"
#include "support/skip.h"

namespace plait::test {

TEST_CASE("SubdivideMemory_OfABaseMeshOfTenTimesTheLimit_IsTheLimitAndTheProgram") {
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
  // 4 million faces. The arrays have 264 MB.
  succeed({"generate", "torus", "large.ply", "--vertices", "2000000"});
  succeed({"layout", "large.ply", "large.base", "--memory", "512M"});
  const auto subdivide = [&](const std::string& name, const std::string& memory) {
    return succeed({"subdivide", "large.base", name, "--levels", "1", "--normals", "--backend",
                    "pread", "--memory", memory, "--durability", "none", "--json"})
        .json();
  };
  const nlohmann::json pieces = subdivide("pieces.plait", "24M"),
                       whole = subdivide("whole.plait", "512M");
  CHECK(pieces["piece_bytes"] == 12 * kMebibyte);
  CHECK(whole["piece_bytes"] == 0);
  CHECK(whole["peak_rss_bytes"] > 264'000'000);
  CHECK(pieces["peak_rss_bytes"] < (24 + 32) * kMebibyte);
  const auto digest = [&](const std::string& name) {
    return succeed({"digest", name, "--json"}).json()["digest"];
  };
  CHECK(digest("pieces.plait") == digest("whole.plait"));
}

}  // namespace plait::test
