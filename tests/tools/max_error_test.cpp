// --max-error of plait convert and plait subdivide: each number keeps its bound, and twice is as
// once.
#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "plait/mesh_io.h"
#include "support/test_meshes.h"
#include "workplace.h"

namespace plait::test {
namespace {

struct RoundingWorkplace : Workplace {
  RoundingWorkplace() {
    write_ply(path("mesh.ply"), random_sphere(7, 200));
    succeed({"subdivide", "mesh.ply", "s.plait", "--levels", "3", "--normals"});
  }
  Outcome convert(const std::string& from, const std::string& to, const Words& options) const {
    return plait({"convert", from, to, "--json"}, options);
  }
  Outcome must_convert(const std::string& from, const std::string& to, const Words& options) const {
    return succeed({"convert", from, to, "--json"}, options);
  }
  nlohmann::json attribute(const std::string& store, std::size_t index) const {
    return report({"info", store})["attributes"][index];
  }
};

/// Another layout adds the squares of errors in another order, so the last bits may differ.
bool is_same(nlohmann::json found, nlohmann::json expected) {
  const double rms = found["rms_error"], other = expected["rms_error"];
  found.erase("rms_error"), expected.erase("rms_error");
  return found == expected && std::abs(rms - other) <= 1e-12 * other;
}

}  // namespace

TEST_CASE("MaxError_Copy_KeepsTheBoundAndRecordsIt") {
  const RoundingWorkplace here;
  const Outcome made = here.must_convert(
      "s.plait", "lossy.plait",
      {"--max-error", "1e-4rel", "--max-error", "normal=1e-3,euclidean", "--verify"});
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
  here.must_convert("lossy.plait", "raw.plait", {"--backend", "pread", "--verify"});
  CHECK(here.digest("raw.plait") == here.digest("lossy.plait"));
  CHECK(here.attribute("raw.plait", 0)["max_error"] == position);
}

TEST_CASE("MaxError_SameBoundAgain_ChangesNothing") {
  const RoundingWorkplace here;
  const Words bound = {"--max-error", "1e-5rel", "--max-error", "normal=1e-4"};
  here.must_convert("s.plait", "once.plait", bound);
  here.must_convert("once.plait", "twice.plait", bound);
  CHECK(here.digest("once.plait") == here.digest("twice.plait"));
  nlohmann::json once = here.report({"info", "once.plait"}),
                 twice = here.report({"info", "twice.plait"});
  for (const char* own : {"store", "uuid"}) once.erase(own), twice.erase(own);
  CHECK(once == twice);
}

TEST_CASE("MaxError_AnyPipelineBlockSizeAndBudget_MakesTheSameRecords") {
  const RoundingWorkplace here;
  const std::vector<Words> ways = {{},
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
    Words options = ways[way];
    for (const char* each : {"--max-error", "2e-4rel", "--max-error", "normal=0.01", "--verify"})
      options.emplace_back(each);
    const Outcome made = here.must_convert("s.plait", store, options);
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
  CHECK_FALSE(here.has("out.plait"));
}

TEST_CASE("SubdivideMaxError_AnyBackendExecutorAndBudget_IsAsSubdivideAndThenConvert") {
  const RoundingWorkplace here;
  const Words bounds = {"--max-error", "1e-4rel", "--max-error", "normal=1e-3,euclidean"};
  here.must_convert("s.plait", "converted.plait", bounds);
  const std::string expected = here.digest("converted.plait");
  const std::vector<Words> ways = {{},
                                   {"--executor", "sweep", "--compress", "small"},
                                   {"--backend", "pread", "--block", "4KiB"},
                                   {"--backend", "mmap", "--memory", "2MiB", "--threads", "1"},
                                   {"--compress", "fast", "--compress", "@1-2=shuffle,lz4"},
                                   {"--backend", "memory"}};
  for (std::size_t way = 0; way < ways.size(); ++way) {
    CAPTURE(way);
    const std::string store = "way" + std::to_string(way) + ".plait";
    const bool in_memory = way + 1 == ways.size();
    Words arguments = {"subdivide", "mesh.ply", "--levels",     "3",   "--normals", "--json",
                       "--digest",  "--verify", "--durability", "none"};
    if (!in_memory) arguments.insert(arguments.begin() + 2, store);
    arguments.insert(arguments.end(), bounds.begin(), bounds.end());
    arguments.insert(arguments.end(), ways[way].begin(), ways[way].end());
    const Outcome made = here.succeed(arguments);
    CHECK(made.json()["digest"] == expected);
    CHECK(made.json()["backend"] == (way == 2   ? "pread"
                                     : way == 3 ? "mmap"
                                     : way == 5 ? "memory"
                                                : "compressed"));
    const nlohmann::json found = made.json()["max_error"],
                         position = here.attribute("converted.plait", 0)["max_error"],
                         normal = here.attribute("converted.plait", 1)["max_error"];
    CHECK(is_same(found["position"], position));
    CHECK(is_same(found["normal"], normal));
    if (in_memory) continue;
    CHECK(here.plait({"verify", store}).status == 0);
    CHECK(here.attribute(store, 0)["max_error"] == found["position"]);
    CHECK(here.attribute(store, 1)["max_error"] == found["normal"]);
    CHECK(here.report({"info", store})["scheme"].get<std::string>().empty());
  }
  // Levels that count in steps, as those of convert.
  for (const std::size_t id : {0u, 1u})
    CHECK(here.attribute("way0.plait", id)["levels"] ==
          here.attribute("converted.plait", id)["levels"]);
}

TEST_CASE("SubdivideMaxError_PositionsAlone_LeavesNormalsAsTheSchemeMadeThem") {
  const RoundingWorkplace here;
  const Outcome made = here.succeed({"subdivide", "mesh.ply", "lossy.plait", "--levels", "3",
                                     "--normals", "--max-error", "1e-3rel", "--executor", "sweep"});
  CHECK(made.output.find("rounded    position: rounded to steps of") != std::string::npos);
  const nlohmann::json normal = here.attribute("lossy.plait", 1);
  CHECK_FALSE(normal.contains("max_error"));
  for (const nlohmann::json& level : normal["levels"])
    CHECK(level["blocks_predicted"] == level["blocks"]);
  // Rounding what was rounded changes nothing.
  here.must_convert("lossy.plait", "again.plait", {"--max-error", "1e-3rel"});
  CHECK(here.digest("again.plait") == here.digest("lossy.plait"));
}

TEST_CASE("SubdivideMaxError_WhatItCannotKeep_IsRefusedBeforeAnyWork") {
  const RoundingWorkplace here;
  const struct {
    Words options;
    const char* words;
  } cases[] = {{{"--max-error", "colour=1e-5"}, "error bounds of position, found one of 'colour'"},
               {{"--max-error", "normal=1e-5"}, "found one of 'normal', which is not asked for"},
               {{"--max-error", "1e-60"}, "(--max-error)"},
               {{"--max-error", "1e-60rel"}, "(--max-error)"},
               {{"--normals", "--max-error", "normal=1e-60rel"}, "round attribute 'normal'"},
               {{"--max-error", "0"}, "choose an error bound"},
               {{"--verify"}, "expected an error bound to verify"},
               {{"--max-error", "1e-5", "--resume"}, "round a copy of the finished store"},
               {{"--max-error", "1e-5", "--compress", "@4=fast"}, "expected levels from 1 to 3"}};
  for (const auto& [options, words] : cases) {
    const Outcome refused =
        here.plait({"subdivide", "mesh.ply", "out.plait", "--levels", "3"}, options);
    CAPTURE(options, refused.errors);
    CHECK(refused.status != 0);
    CHECK(refused.error_lines() == 1);
    CHECK(refused.errors.find(words) != std::string::npos);
    CHECK_FALSE(here.has("out.plait"));
  }
  // No finer level is made from rounded ones.
  here.succeed({"subdivide", "mesh.ply", "out.plait", "--levels", "2", "--max-error", "1e-4",
                "--backend", "pread"});
  const Outcome resumed =
      here.plait({"subdivide", "mesh.ply", "out.plait", "--levels", "3", "--resume"});
  CHECK(resumed.status == 2);
  CHECK(resumed.errors.find("its positions are rounded") != std::string::npos);
}

}  // namespace plait::test
