// plait convert --max-error: the copy keeps its bound, and twice is as once.
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "plait/mesh_io.h"
#include "program.h"
#include "support/test_meshes.h"

namespace plait::test {
namespace {

using Names = std::vector<std::string>;

struct RoundingWorkplace {
  TemporaryDirectory directory;
  RoundingWorkplace() {
    write_ply(directory.path() / "mesh.ply", random_sphere(7, 200));
    REQUIRE(plait({"subdivide", "mesh.ply", "s.plait", "--levels", "3", "--normals"}).status == 0);
  }
  Outcome plait(Names arguments) const { return run(directory.path(), std::move(arguments)); }
  Outcome convert(const std::string& from, const std::string& to, Names options) const {
    Names arguments = {"convert", from, to, "--json"};
    arguments.insert(arguments.end(), options.begin(), options.end());
    return plait(arguments);
  }
  std::string digest(const std::string& store) const {
    return plait({"digest", store}).last_line();
  }
  nlohmann::json attribute(const std::string& store, std::size_t index) const {
    return plait({"info", store, "--json"}).json()["attributes"][index];
  }
};

}  // namespace

TEST_CASE("MaxError_Copy_KeepsTheBoundAndRecordsIt") {
  const RoundingWorkplace here;
  const Outcome made =
      here.convert("s.plait", "lossy.plait",
                   {"--max-error", "1e-4rel", "--max-error", "normal=1e-3,euclidean", "--verify"});
  CAPTURE(made.errors);
  REQUIRE(made.status == 0);
  CHECK(made.json()["backend"] == "compressed");
  CHECK(made.json()["digest"] == here.digest("lossy.plait"));
  CHECK(here.digest("lossy.plait") != here.digest("s.plait"));
  const nlohmann::json position = here.attribute("lossy.plait", 0)["max_error"],
                       normal = here.attribute("lossy.plait", 1)["max_error"];
  CHECK(position == made.json()["max_error"]["position"]);
  CHECK(normal == made.json()["max_error"]["normal"]);
  CHECK(position["metric"] == "component");
  CHECK(normal["metric"] == "euclidean");
  CHECK(normal["bound"] == 1e-3);
  for (const nlohmann::json& found : {position, normal}) {
    CHECK(found["largest_error"] <= found["bound"]);
    CHECK(found["largest_error"] > 0.5 * found["bound"].get<double>());
    CHECK(found["rms_error"] < found["largest_error"]);
    CHECK(found["rms_error"] > 0);
  }
  const Outcome info = here.plait({"info", "lossy.plait"});
  CHECK(info.output.find("error at most 0.001 (euclidean), largest found") != std::string::npos);
  CHECK(here.attribute("s.plait", 0)["max_error"].is_null());
  // A copy without the option keeps the records and what is said of them.
  REQUIRE(here.convert("lossy.plait", "raw.plait", {"--backend", "pread", "--verify"}).status == 0);
  CHECK(here.digest("raw.plait") == here.digest("lossy.plait"));
  CHECK(here.attribute("raw.plait", 0)["max_error"] == position);
}

TEST_CASE("MaxError_SameBoundAgain_ChangesNothing") {
  const RoundingWorkplace here;
  const Names bound = {"--max-error", "1e-5rel", "--max-error", "normal=1e-4"};
  REQUIRE(here.convert("s.plait", "once.plait", bound).status == 0);
  REQUIRE(here.convert("once.plait", "twice.plait", bound).status == 0);
  CHECK(here.digest("once.plait") == here.digest("twice.plait"));
  nlohmann::json once = here.plait({"info", "once.plait", "--json"}).json(),
                 twice = here.plait({"info", "twice.plait", "--json"}).json();
  for (const char* own : {"store", "uuid"}) once.erase(own), twice.erase(own);
  CHECK(once == twice);
}

TEST_CASE("MaxError_AnyPipelineBlockSizeAndBudget_MakesTheSameRecords") {
  const RoundingWorkplace here;
  const std::vector<Names> ways = {{},
                                   {"--compress", "fast"},
                                   {"--compress", "small", "--block", "4KiB"},
                                   {"--compress", "hierarchy:midpoint+shuffle,lz4"},
                                   {"--compress", "none"},
                                   {"--compress", "shuffle,zstd:1", "--memory", "16MiB"},
                                   {"--backend", "mmap", "--block", "64KiB"}};
  std::string expected;
  for (std::size_t way = 0; way < ways.size(); ++way) {
    CAPTURE(way);
    const std::string store = "way" + std::to_string(way) + ".plait";
    Names options = ways[way];
    for (const char* each : {"--max-error", "2e-4rel", "--max-error", "normal=0.01", "--verify"})
      options.emplace_back(each);
    const Outcome made = here.convert("s.plait", store, options);
    CAPTURE(made.errors);
    REQUIRE(made.status == 0);
    const std::string found = here.digest(store);
    if (way == 0) expected = found;
    CHECK(found == expected);
    CHECK(here.plait({"verify", store}).status == 0);
  }
}

TEST_CASE("MaxError_TextsAndAttributesThatItDoesNotTake_AreRefused") {
  const RoundingWorkplace here;
  for (const char* text :
       {"0", "-1e-5", "nan", "inf", "1e-5rell", "", "1e-5,manhattan", "normal="}) {
    CAPTURE(text);
    const Outcome refused = here.convert("s.plait", "out.plait", {"--max-error", text});
    CHECK(refused.status == 2);
    CHECK(refused.error_lines() == 1);
  }
  CHECK(here.convert("s.plait", "out.plait", {"--max-error", "colour=1e-5"}).status != 0);
  CHECK(here.convert("s.plait", "out.plait", {"--max-error", "1e-60"}).status != 0);
  CHECK_FALSE(std::filesystem::exists(here.directory.path() / "out.plait"));
}

}  // namespace plait::test
