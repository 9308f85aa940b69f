// The promises of the commands about stores: one digest for all backends, damage is named, a store
// is replaced only at the end.
#include <fmt/format.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <fstream>
#include <string>
#include <vector>

#include "blocks/telling_volume.h"
#include "conversion/read_back.h"
#include "plait/extend/notices.h"
#include "plait/mesh_io.h"
#include "plait/reader.h"
#include "plait/registry.h"
#include "stand_ins.h"
#include "support/sanitized.h"
#include "support/test_meshes.h"
#include "workplace.h"

namespace plait::test {
namespace {

struct StoreWorkplace : Workplace {
  StoreWorkplace() { write_ply(path("mesh.ply"), random_sphere(7, 300)); }
  Outcome subdivide(const std::string& store, const Words& options) const {
    return plait({"subdivide", "mesh.ply", store, "--levels", "3"}, options);
  }
  Outcome must_subdivide(const std::string& store, const Words& options) const {
    return succeed({"subdivide", "mesh.ply", store, "--levels", "3"}, options);
  }
};

/// The largest file of a store: the finest level of an attribute.
std::filesystem::path largest_file(const std::filesystem::path& store) {
  std::filesystem::path largest;
  for (const auto& entry : std::filesystem::directory_iterator(store))
    if (largest.empty() || entry.file_size() > std::filesystem::file_size(largest))
      largest = entry.path();
  return largest;
}

}  // namespace

TEST_CASE("Digest_OfOneLevel_DiffersFromAllAndNeedsTheLevel") {
  const StoreWorkplace here;
  here.must_subdivide("s.plait", {});
  const Outcome one = here.plait({"digest", "s.plait", "--level", "2"});
  CHECK(one.status == 0);
  CHECK(one.last_line() != here.digest("s.plait"));
  CHECK(here.plait({"digest", "s.plait", "--level", "4"}).status == 2);
}

TEST_CASE("Subdivide_Json_HasTheFiguresOfTheContract") {
  const StoreWorkplace here;
  const Outcome outcome = here.must_subdivide(
      "s.plait", {"--json", "--digest", "--executor", "transparent", "--threads", "2"});
  const nlohmann::json report = outcome.json();
  for (const char* key : {"levels",         "vertices",          "seconds",
                          "import_seconds", "layout_seconds",    "refine_seconds",
                          "commit_seconds", "cpu_seconds",       "ns_per_vertex",
                          "bytes_written",  "bytes_read",        "stored_bytes",
                          "peak_rss_bytes", "base_mesh_bytes",   "budget_bytes",
                          "backend",        "pipelines",         "block_bytes",
                          "executor",       "threads",           "layout",
                          "span",           "level_counts",      "digest",
                          "paging",         "read_wait_seconds", "write_wait_seconds"}) {
    CAPTURE(key);
    CHECK(report.contains(key));
  }
  CHECK(report["threads"] == 1);
  CHECK(report["digest"] == here.digest("s.plait"));
  double parts = 0;
  for (const char* part : {"import", "layout", "refine", "commit", "digest"})
    parts += report[std::string(part) + "_seconds"].get<double>();
  CHECK(report["seconds"] >= parts);
  const nlohmann::json without = here.subdivide("without.plait", {"--json"}).json();
  CHECK(!without.contains("digest"));
  std::uint64_t vertices = report["input"]["vertices"], edges = report["input"]["edges"],
                faces = report["input"]["faces"];
  for (const auto& counts : report["level_counts"]) {
    CHECK(counts["vertices"] == vertices);
    CHECK(counts["edges"] == edges);
    CHECK(counts["faces"] == faces);
    vertices += edges;
    edges = 2 * edges + 3 * faces;
    faces *= 4;
  }
  CHECK(report["level_counts"].size() == 4);
  CHECK(report["level_counts"][3]["vertices"] == report["vertices"]);
  const nlohmann::json in_memory =
      here.report({"subdivide", "mesh.ply", "--levels", "3", "--backend", "memory", "--digest"});
  CHECK(in_memory["digest"] == report["digest"]);
  CHECK(in_memory["store"].is_null());
}

TEST_CASE("Subdivide_SmallSlotLimit_KeepsLevelNumbersAndSurface") {
  const StoreWorkplace here;
  here.must_subdivide("s.plait", {"--max-slot", "64", "--json"});
  const nlohmann::json info = here.report({"info", "s.plait"});
  CHECK(info["base_level"].get<int>() > 0);
  CHECK(info["finest_level"] == 3);
  here.must_subdivide("t.plait", {});
  CHECK(info["finest"] == here.report({"info", "t.plait"})["finest"]);
}

TEST_CASE("Info_OfAStore_AddsUp") {
  const StoreWorkplace here;
  here.must_subdivide("s.plait", {"--normals", "--backend", "compressed"});
  const nlohmann::json info = here.report({"info", "s.plait"});
  CHECK(info["backend"] == "compressed");
  CHECK(info["scheme"] == "loop");
  CHECK(info["limit"] == false);
  CHECK(info["precision"] == "float32");
  CHECK(info["program"].get<std::string>().starts_with("0."));
  REQUIRE(info["attributes"].size() == 2);
  for (const auto& attribute : info["attributes"]) {
    std::uint64_t vertices = info["base"]["vertices"];
    for (const auto& level : attribute["levels"]) {
      CHECK(level["raw_bytes"] == level["vertices"].get<std::uint64_t>() * 12);
      CHECK(level["blocks_never_written"] == 0);
      vertices += level["vertices"].get<std::uint64_t>();
    }
    CHECK(vertices == info["finest"]["vertices"]);
  }
}

TEST_CASE("InfoBuild_NamesWhatAStoreMayNeed") {
  const StoreWorkplace here;
  const nlohmann::json build = here.report({"info", "--build"});
  CHECK(build["codecs"] == nlohmann::json({"bitpack", "lz4", "none", "zstd"}));
  CHECK(build["filters"] ==
        nlohmann::json({"columns", "hierarchy", "lattice", "normals", "shuffle"}));
  CHECK(build["schemes"] == nlohmann::json({"loop", "butterfly", "midpoint"}));
  REQUIRE(build["backends"].size() == 5);
  const std::string text = here.plait({"info", "--build"}).output;
  for (const auto& backend : build["backends"]) {
    CHECK(text.find(backend["name"].get<std::string>()) != std::string::npos);
    CHECK(backend["available"] == !backend.contains("reason"));
  }
  CHECK(here.plait({"info"}).status == 2);
  CHECK(here.plait({"info", "s.plait", "--build"}).status == 2);
}

TEST_CASE("Verify_OneFlippedByte_EndsWithOneAndNamesTheBlock") {
  const StoreWorkplace here;
  for (const std::string backend : {"pread", "mmap", "compressed"}) {
    CAPTURE(backend);
    const std::string store = backend + ".plait";
    here.must_subdivide(store, {"--backend", backend, "--block", "4KiB"});
    CHECK(here.plait({"verify", store}).status == 0);
    flip_byte(largest_file(here.path(store)), 5000);
    const Outcome outcome = here.plait({"verify", store});
    CHECK(outcome.status == 1);
    CHECK(outcome.output.find("damaged: position, level 3, block ") == 0);
    const nlohmann::json report = here.plait({"verify", store, "--json"}).json();
    CHECK(report["ok"] == false);
    REQUIRE(report["damaged_count"] == 1);
    const auto& damaged = report["damaged"][0];
    CHECK(damaged["file_offset"].get<std::uint64_t>() <= 5000);
    CHECK(damaged["first_edge"].get<std::uint64_t>() < damaged["edge_after"].get<std::uint64_t>());
  }
}

TEST_CASE("Verify_Fast_ChecksAllButTheBlocks") {
  const StoreWorkplace here;
  for (const std::string backend : {"pread", "mmap", "compressed"}) {
    CAPTURE(backend);
    const std::string store = backend + ".plait";
    here.must_subdivide(store, {"--backend", backend, "--normals"});
    flip_byte(largest_file(here.path(store)), 5000);  // inside a block
    const Outcome fast = here.plait({"verify", store, "--fast"});
    CHECK(fast.status == 0);
    CHECK(fast.output.find("blocks not read") != std::string::npos);
    CHECK(here.plait({"verify", store, "--fast", "--json"}).json()["blocks_read"] == false);
    CHECK(here.plait({"verify", store}).status == 1);

    flip_byte(here.path(store) / "attribute1.base.1", 3);
    std::filesystem::remove(here.path(store) / "attribute0.level01.1");
    std::filesystem::resize_file(here.path(store) / "attribute1.level03.1", 100);
    std::ofstream(here.path(store) / "version.9") << "of no version";
    for (const Words& option : {Words{}, Words{"--fast"}}) {
      const Outcome outcome = here.plait({"verify", store, "--json"}, option);
      CHECK(outcome.status == 1);
      const nlohmann::json report = outcome.json();
      CHECK(report["ok"] == false);
      CHECK(report["blocks_read"] == false);
      REQUIRE(report["damaged_files"].size() == 3);
      CHECK(report["damaged_files"][0]["file"] == "attribute0.level01.1");
      CHECK(report["damaged_files"][1]["file"] == "attribute1.base.1");
      CHECK(report["damaged_files"][2]["file"] == "attribute1.level03.1");
      CHECK(report["left_over"] == Words{"version.9"});
    }
  }
}

TEST_CASE("Convert_ThereAndBack_KeepsTheDigest") {
  const StoreWorkplace here;
  here.must_subdivide("s.plait", {"--normals"});
  const std::string expected = here.digest("s.plait");
  here.succeed({"convert", "s.plait", "c.plait", "--compress", "small", "--compress",
                "normal=zstd:5", "--block", "64K"});
  CHECK(here.digest("c.plait") == expected);
  const auto pipeline_of = [&](const char* store, int attribute) {
    const auto info = here.report({"info", store});
    return info["attributes"][static_cast<std::size_t>(attribute)]["levels"][0]["pipeline"];
  };
  CHECK(pipeline_of("c.plait", 0) ==
        "predicted:loop/position/float32/3+hierarchy:along+shuffle,zstd:9");
  CHECK(pipeline_of("c.plait", 1) == "zstd:5");
  here.succeed({"convert", "c.plait", "same.plait", "--block", "16K"});
  CHECK(here.digest("same.plait") == expected);
  CHECK(pipeline_of("same.plait", 0) ==
        "predicted:loop/position/float32/3+hierarchy:along+shuffle,zstd:9");
  CHECK(pipeline_of("same.plait", 1) == "zstd:5");
  here.succeed({"convert", "c.plait", "m.plait", "--backend", "mmap"});
  CHECK(here.digest("m.plait") == expected);
  CHECK(here.plait({"verify", "m.plait"}).status == 0);
}

TEST_CASE("Compress_RangesOfLevels_AreStoredAndShown") {
  const StoreWorkplace here;
  here.must_subdivide("s.plait", {"--normals"});
  const std::string expected = here.digest("s.plait");
  const auto pipelines_of = [&](const std::string& store, std::size_t attribute) {
    return here.report({"info", store})["attributes"][attribute]["pipelines"];
  };
  const auto range = [](int first, int last, const char* pipeline) {
    return nlohmann::json{{"first_level", first}, {"last_level", last}, {"pipeline", pipeline}};
  };
  const Words options = {"--compress", "zstd:2",  "--compress", "position@1-2=shuffle,zstd:3",
                         "--compress", "@2-=lz4", "--compress", "normal=normals+shuffle,zstd:1"};
  Words convert = {"convert", "s.plait", "c.plait", "--verify"};
  convert.insert(convert.end(), options.begin(), options.end());
  here.succeed(convert);
  here.must_subdivide("made.plait", [&] {
    Words all = {"--normals"};
    all.insert(all.end(), options.begin(), options.end());
    return all;
  }());
  // A copy is like its source in everything that no option changes.
  here.succeed({"convert", "c.plait", "again.plait", "--block", "16K"});
  // A later run of a resumed store may choose for the levels that it adds, and for no others.
  const auto resume = [&](const char* level, Words texts) {
    Words arguments = {"subdivide", "mesh.ply", "resumed.plait", "--levels", level, "--resume"};
    for (std::string& text : texts) arguments.insert(arguments.end(), {"--compress", text});
    return here.plait(arguments);
  };
  const Outcome too_fine = resume("1", {"shuffle,zstd:3", "@3-=lz4"});
  CHECK(too_fine.status == 2);
  CHECK(too_fine.errors.find("levels 3-: expected levels from 1 to 1") != std::string::npos);
  REQUIRE(resume("1", {"shuffle,zstd:3"}).status == 0);
  CHECK(resume("3", {"shuffle,zstd:3", "@1=lz4"}).status == 2);
  REQUIRE(resume("3", {"shuffle,zstd:3", "@3-=lz4"}).status == 0);
  CHECK(pipelines_of("resumed.plait", 0) ==
        nlohmann::json::array({range(1, 2, "shuffle,zstd:3"), range(3, 3, "lz4")}));
  for (const char* store : {"c.plait", "made.plait", "again.plait"}) {
    CAPTURE(store);
    CHECK(here.digest(store) == expected);
    CHECK(here.plait({"verify", store}).status == 0);
    CHECK(pipelines_of(store, 0) ==
          nlohmann::json::array({range(1, 2, "shuffle,zstd:3"), range(3, 3, "lz4")}));
    CHECK(pipelines_of(store, 1) == nlohmann::json::array({range(1, 3, "normals+shuffle,zstd:1")}));
    const std::string text = here.plait({"info", store}).output;
    CHECK(text.find("\n  levels 1-2  shuffle,zstd:3\n  level 3     lz4\n") != std::string::npos);
    CHECK(text.find("\n  levels 1-3  normals+shuffle,zstd:1\n") != std::string::npos);
  }
  CHECK(here.subdivide("json.plait", {"--json", "--compress", "none", "--compress", "@2=lz4"})
            .json()["pipelines"]["position"] == "none;@2=lz4");
  for (const Words& wrong : std::vector<Words>{{"@4-5=lz4"}, {"@1-2=lz4", "@2-3=zstd:1"}, {"@2"}}) {
    Words refused = {"convert", "s.plait", "out.plait"};
    for (const std::string& text : wrong) refused.insert(refused.end(), {"--compress", text});
    const Outcome outcome = here.plait(refused);
    CAPTURE(wrong, outcome.errors);
    CHECK(outcome.status == 2);
    CHECK(outcome.error_lines() == 1);
    CHECK_FALSE(here.has("out.plait"));
  }
}

TEST_CASE("Convert_NormalsOfMovedVertices_AreMadeAgainAndTakeNoBytes") {
  const StoreWorkplace here;
  here.must_subdivide("s.plait", {"--normals", "--backend", "pread"});
  const Outcome made = here.subdivide("made.plait", {"--normals", "--compress", "small"});
  CHECK(made.output.find("position: ") < made.output.find(" blocks take no bytes"));
  here.succeed({"displace", "s.plait", "moved.plait", "--amplitude", "1e-3"});
  const std::string expected = here.digest("moved.plait");
  const auto normal_of = [&](const char* store) {
    return here.report({"info", store})["attributes"][1];
  };
  here.succeed({"export", "moved.plait", "a.ply"});
  for (const std::string preset : {"default", "small"}) {
    CAPTURE(preset);
    const std::string store = preset + ".plait";
    const Outcome copy =
        here.succeed({"convert", "moved.plait", store, "--compress", preset, "--verify"});
    CHECK(copy.output.find("reading makes them again (normals/position/") != std::string::npos);
    CHECK(here.digest(store.c_str()) == expected);
    const auto normal = normal_of(store.c_str());
    for (const auto& level : normal["levels"]) {
      CHECK(level["stored_bytes"] == 0);
      CHECK(level["blocks_predicted"] == level["blocks"]);
    }
    CHECK(here.plait({"info", store}).output.find("blocks take no bytes") != std::string::npos);
    CHECK(here.plait({"verify", store}).status == 0);
    here.succeed({"export", store, preset + ".ply"});
  }
  // A copy is like its source.
  here.succeed({"convert", "small.plait", "copy.plait", "--block", "64KiB"});
  CHECK(here.digest("copy.plait") == expected);
  CHECK(normal_of("copy.plait")["levels"][0]["blocks_predicted"] ==
        normal_of("copy.plait")["levels"][0]["blocks"]);
  // The preset fast stores them.
  here.succeed({"convert", "small.plait", "fast.plait", "--compress", "fast"});
  const auto stored_normal = normal_of("fast.plait");
  for (const auto& level : stored_normal["levels"]) CHECK(level["blocks_predicted"] == 0);
  CHECK(here.digest("fast.plait") == expected);
  // Moved again, they follow from the new positions.
  for (const char* const store : {"moved", "small"})
    here.succeed({"displace", fmt::format("{}.plait", store), fmt::format("{}-again.plait", store),
                  "--amplitude", "1e-3"});
  CHECK(here.digest("small-again.plait") == here.digest("moved-again.plait"));
  CHECK(normal_of("small-again.plait")["levels"][0]["stored_bytes"] == 0);
}

TEST_CASE("Convert_RoundedPositions_NormalsAreNotMadeFromThem") {
  const StoreWorkplace here;
  here.must_subdivide("s.plait", {"--normals", "--backend", "pread"});
  const Outcome lossy = here.succeed({"convert", "s.plait", "lossy.plait", "--max-error", "1e-4",
                                      "--compress", "small", "--verify"});
  CHECK(lossy.output.find("(normals/position/") == std::string::npos);
  const auto info = here.report({"info", "lossy.plait"});
  const auto& position = info["attributes"][0];
  REQUIRE(position["levels"].size() == 3);
  for (const auto& level : position["levels"]) CHECK(level["stored_bytes"] != 0);
  // The scheme makes the same normals of the base mesh as before.
  const auto& normal = info["attributes"][1];
  for (const auto& level : normal["levels"]) CHECK(level["blocks_predicted"] == level["blocks"]);
}

TEST_CASE("Displace_MovesTheCopyAndNotTheStore") {
  const StoreWorkplace here;
  here.must_subdivide("s.plait", {"--normals"});
  const std::string before = here.digest("s.plait");
  Words digests;
  for (const Words& how : std::vector<Words>{
           {"noise.plait", "--amplitude", "0.001"},
           {"again.plait", "--amplitude", "0.001", "--threads", "1", "--backend", "compressed"},
           {"other.plait", "--amplitude", "0.001", "--seed", "2"},
           {"fractal.plait", "--kind", "fractal"},
           {"still.plait", "--amplitude", "0"}}) {
    const Outcome outcome = here.plait({"displace", "s.plait"}, how);
    CAPTURE(how, outcome.errors);
    REQUIRE(outcome.status == 0);
    digests.push_back(here.digest(how[0]));
    CHECK(here.plait({"verify", how[0]}).status == 0);
  }
  CHECK(here.digest("s.plait") == before);
  CHECK(digests[0] != before);
  CHECK(digests[0] == digests[1]);
  CHECK(digests[0] != digests[2]);
  CHECK(digests[0] != digests[3]);
  CHECK(digests[4] == before);  // normals made anew are those that the scheme made
  // The levels do not follow from the base mesh any more.
  CHECK(here.report({"info", "noise.plait"})["scheme"] == "");
  // Levels that are predicted from coarser ones can be displaced, too.
  here.succeed(
      {"displace", "s.plait", "small.plait", "--amplitude", "0.001", "--compress", "default"});
  REQUIRE(here.plait({"displace", "small.plait", "again_small.plait", "--amplitude", "0"}).status ==
          0);
  CHECK(here.digest("small.plait") == digests[0]);
  CHECK(here.digest("again_small.plait") == digests[0]);
  CHECK(here.plait({"info", "again_small.plait"}).output.find("hierarchy") != std::string::npos);
  CHECK(here.plait({"displace", "s.plait", "noise.plait"}).status == 2);
  CHECK(here.plait({"displace", "s.plait", "s.plait", "--force"}).status == 2);
}

TEST_CASE("Pass_OverTheStore_IsTheNextVersionWithTheRecordsOfACopy") {
  const StoreWorkplace here;
  for (const Words& how : std::vector<Words>{
           {"--backend", "pread"}, {"--compress", "default"}, {"--compress", "small"}}) {
    if (unless_sanitized(false, true) && how.back() == "default") continue;
    CAPTURE(how);
    Words options = {"--normals", "--force"};
    options.insert(options.end(), how.begin(), how.end());
    here.must_subdivide("s.plait", options);
    const std::string first = here.digest("s.plait");
    // Normals made anew are those that the scheme made.
    here.succeed({"pass", "s.plait", "normals"});
    CHECK(here.digest("s.plait") == first);
    for (const char* const kind : {"smooth", "noise", "fractal"}) {
      CAPTURE(kind);
      const auto copy =
          here.plait({"pass", "s.plait", kind, "copy.plait", "--force", "--json"}).json();
      CHECK(copy["made"] == nlohmann::json{"position", "normal"});
      CHECK(copy["largest_move"] > 0);
      const std::string before = here.digest("s.plait");
      const auto next = here.plait({"pass", "s.plait", kind, "--json"}).json();
      CHECK(next["largest_move"] == copy["largest_move"]);
      CHECK(here.digest("s.plait") != before);
      CHECK(here.digest("s.plait") == here.digest("copy.plait"));
      CHECK(here.report({"info", "s.plait"})["scheme"] == "");
      CHECK(here.plait({"verify", "s.plait"}).status == 0);
      // The normals of the pass are those of the new positions.
      const std::string made = here.digest("s.plait");
      here.succeed({"pass", "s.plait", "normals"});
      CHECK(here.digest("s.plait") == made);
    }
    const auto info = here.report({"info", "s.plait"});
    CHECK(info["sequence"] == 8);
    if (how[0] == "--compress") CHECK(info["attributes"][1]["levels"][0]["stored_bytes"] == 0);
  }
}

TEST_CASE("Pass_OptionsWithoutMeaning_AreRefusedAndTheStoreStays") {
  const StoreWorkplace here;
  here.must_subdivide("s.plait", {});
  const std::string before = here.digest("s.plait");
  for (const Words& how : std::vector<Words>{{"smooth", "--force"},
                                             {"smooth", "--block", "64KiB"},
                                             {"smooth", "--compress", "fast"},
                                             {"noise", "--factor", "0.5"},
                                             {"normals", "--seed", "2"},
                                             {"smooth", "s.plait"},
                                             {"wavy"},
                                             {"smooth", "--factor", "2"}}) {
    const Outcome refused = here.plait({"pass", "s.plait"}, how);
    CAPTURE(how, refused.errors);
    CHECK(refused.status == 2);
    if (how.size() > 2) CHECK(refused.errors.find(how[1]) != std::string::npos);
  }
  CHECK(here.digest("s.plait") == before);
  CHECK(here.report({"info", "s.plait"})["sequence"] == 1);
}

TEST_CASE("Displace_Json_TellsWhatItMeasured") {
  const StoreWorkplace here;
  here.must_subdivide("s.plait", {});
  const nlohmann::json noise = here.plait({"displace", "s.plait", "a.plait", "--json"}).json();
  CHECK(noise["kind"] == "noise");
  CHECK(noise["amplitude"] == 3e-7);
  CHECK(noise["seed"] == 1);
  CHECK(!noise.contains("wavelengths"));
  const nlohmann::json fractal =
      here.plait({"displace", "s.plait", "b.plait", "--kind", "fractal", "--json"}).json();
  CHECK(fractal["amplitude"] == 0.005);
  const double diagonal = fractal["diagonal"], edge = fractal["mean_edge"];
  CHECK(fractal["wavelengths"][0] == diagonal / 8);
  CHECK(fractal["wavelengths"].back() >= 4 * edge);
  CHECK(fractal["largest_move"] > 0);
  CHECK(fractal["stored_bytes"] > 0);
}

TEST_CASE("Info_OfAnExactSurface_CountsPredictedBlocksThatTakeNoByte") {
  const StoreWorkplace here;
  here.must_subdivide("s.plait", {"--compress", "default", "--normals"});
  const nlohmann::json info = here.report({"info", "s.plait"});
  CHECK(info["levels_stored_bytes"] == 0);
  CHECK(info["ratio"].get<double>() >= 100);
  std::uint64_t blocks = 0;
  for (const auto& attribute : info["attributes"])
    for (const auto& level : attribute["levels"]) {
      CHECK(level["blocks_predicted"] == level["blocks"]);
      blocks += level["blocks"].get<std::uint64_t>();
    }
  CHECK(info["block_tables_bytes"] == 24 * blocks);
  CHECK(here.plait({"info", "s.plait"}).output.find("predicted:loop/normal/float32/3") !=
        std::string::npos);
  CHECK(here.plait({"verify", "s.plait"}).status == 0);
}

TEST_CASE("Info_OfCompressedLevels_CountsRawBlocksAndTellsTheRatio") {
  const StoreWorkplace here;
  here.must_subdivide("s.plait", {"--compress", "shuffle,zstd:1", "--block", "4KiB", "--normals"});
  here.must_subdivide("none.plait", {"--compress", "none", "--block", "4KiB"});
  here.must_subdivide("raw.plait", {"--block", "4KiB"});
  for (const std::string store : {"s.plait", "none.plait", "raw.plait"}) {
    const nlohmann::json info = here.report({"info", store});
    std::uint64_t raw = 0, stored = 0, blocks = 0, raw_blocks = 0;
    for (const auto& attribute : info["attributes"])
      for (const auto& level : attribute["levels"]) {
        raw += level["raw_bytes"].get<std::uint64_t>();
        stored += level["stored_bytes"].get<std::uint64_t>();
        blocks += level["blocks"].get<std::uint64_t>();
        raw_blocks += level["blocks_raw"].get<std::uint64_t>();
      }
    CAPTURE(store);
    CHECK(info["ratio"].get<double>() == Approx(double(raw) / double(stored)));
    const std::string text = here.plait({"info", store}).output;
    CHECK(text.find(fmt::format("{:.2f} to 1", double(raw) / double(stored))) != std::string::npos);
    CHECK((text.find("less than an eighth") != std::string::npos) == (store != "raw.plait"));
    CHECK((raw_blocks == blocks) == (store != "s.plait"));
  }
}

TEST_CASE("Bounds_OfAStore_AreThoseOfItsVertices") {
  const StoreWorkplace here;
  here.must_subdivide("s.plait", {"--normals"});
  const Outcome outcome = here.succeed({"bounds", "s.plait", "--json"});
  CHECK(here.plait({"verify", "s.plait", "--json"}).json()["notes"].empty());

  // The file by docs/format.md, and the vertices read one by one.
  const Store store = Store::open(here.path("s.plait"), {}, default_backends());
  CHECK(outcome.json()["faces"] == store.base().face_count());
  std::ifstream file(here.path("s.plait/attribute0.bounds"), std::ios::binary);
  file.seekg(32);
  const Reader reader(store, {.attributes = {"position"}});
  std::uint64_t wrong = 0;
  for (FaceId face = 0; face < store.base().face_count(); ++face) {
    float found[2][3];
    file.read(reinterpret_cast<char*>(found), sizeof(found));
    const PatchView patch = reader.read_patch(face, 3);
    const auto position = patch.attribute<Vector3<float>>("position");
    for (int axis = 0; axis < 3; ++axis) {
      float low = position.at(0, 0)[axis], high = low;
      for (std::int64_t j = 0; j <= 8; ++j)
        for (std::int64_t i = 0; i + j <= 8; ++i) {
          low = std::min(low, position.at(i, j)[axis]);
          high = std::max(high, position.at(i, j)[axis]);
        }
      wrong += found[0][axis] != low || found[1][axis] != high;
    }
  }
  CHECK(wrong == 0);
  CHECK(file.good());

  CHECK(here.plait({"bounds", "s.plait", "--attribute", "normal"}).status == 0);
  CHECK(here.has("s.plait/attribute1.bounds"));
  const Outcome unknown = here.plait({"bounds", "s.plait", "--attribute", "mass"});
  CHECK(unknown.status == 2);
  CHECK(unknown.error_lines() == 1);
}

TEST_CASE("Commands_OnADirectoryThatIsNoStore_SayThatItIsNone") {
  const StoreWorkplace here;
  for (const char* command : {"info", "verify", "digest", "bounds", "repair"}) {
    const Outcome outcome = here.plait({command, "."});
    CAPTURE(command, outcome.errors);
    CHECK(outcome.status == 2);
    CHECK(outcome.errors ==
          "plait: open .: expected a store, found a directory with neither a lock nor the manifest "
          "of a store\n");
  }
}

TEST_CASE("Compress_WithABackendThatDoesNotCompress_NamesTheOptionToAdd") {
  const StoreWorkplace here;
  here.must_subdivide("s.plait", {});
  CHECK(here.subdivide("c.plait", {"--backend", "pread", "--compress", "lz4"})
            .errors.find("choose backend compressed") != std::string::npos);
  CHECK(here.plait({"convert", "s.plait", "c.plait", "--backend", "mmap", "--compress", "fast"})
            .errors.find("choose backend compressed") != std::string::npos);
}

TEST_CASE("Convert_Verify_TellsTheDigestThatItReadBack") {
  const StoreWorkplace here;
  here.must_subdivide("s.plait", {"--normals"});
  const Outcome plain = here.plait({"convert", "s.plait", "a.plait", "--json"});
  CHECK(!plain.json().contains("digest"));
  const Outcome verified = here.plait(
      {"convert", "s.plait", "b.plait", "--backend", "compressed", "--verify", "--json"});
  CHECK(verified.json()["digest"] == here.digest("s.plait"));
}

TEST_CASE("CompareCopy_OfAnotherOrADamagedStore_IsRefused") {
  const StoreWorkplace here;
  here.must_subdivide("s.plait", {});
  here.must_subdivide("other.plait", {"--scheme", "midpoint"});
  here.succeed({"convert", "s.plait", "copy.plait"});
  Store source = Store::open(here.path("s.plait"), {}, default_backends());
  const auto compare = [&](const std::string& copy) {
    return compare_copy(source, here.path(copy), {}, 1, default_backends());
  };
  CHECK(compare("copy.plait") == here.digest("s.plait"));
  CHECK_THROWS_WITH(compare("other.plait"), Catch::Contains("read back"));
  flip_byte(largest_file(here.path("copy.plait")), 1000);
  CHECK_THROWS_AS(compare("copy.plait"), Error);
}

/// A volume of pread that has something to say.
class TellingPread final : public Volume, public TellingVolume {
 public:
  explicit TellingPread(const VolumeSpec& spec)
      : volume_(default_backends().find("pread").open(spec)) {}
  std::unique_ptr<Backend> open_level(const LevelSpec& level) override {
    return volume_->open_level(level);
  }
  Words notices() const override { return {"read with spoons"}; }

 private:
  std::unique_ptr<Volume> volume_;
};

TEST_CASE("Notices_OfABackend_AreSaidOnceForEachLineAndHeldByTheStore") {
  const StoreWorkplace here;
  RegisteredBackend entry = default_backends().find("pread");
  entry.open = [](const VolumeSpec& spec) { return std::make_unique<TellingPread>(spec); };
  BackendRegistry registry;
  registry.add(entry);
  Words warnings;
  const BackendRegistry warning =
      with_warnings(registry, [&](const std::string& line) { warnings.push_back(line); });
  const Words said = {"read with spoons"};
  {
    Store store = Store::create(here.path("s.plait"), BaseMesh::build(icosahedron()),
                                {.backend = "pread"}, warning);
    store.add_level(store.add_attribute(schema_of<float>("value")));
    store.commit();
    CHECK(notices(store) == said);
  }
  for (const bool writable : {false, true})
    CHECK(notices(Store::open(here.path("s.plait"), {.writable = writable}, warning)) == said);
  CHECK(warnings == said);
  CHECK(notices(Store::open(here.path("s.plait"), {}, default_backends())).empty());
}

TEST_CASE("Convert_WhatMakesNoSense_IsRefusedAndLeavesNothing") {
  const StoreWorkplace here;
  here.must_subdivide("s.plait", {});
  const Words before = here.names();
  for (const Words& options :
       std::vector<Words>{{"s.plait", "--force"},
                          {"c.plait", "--backend", "memory"},
                          {"c.plait", "--backend", "pread", "--compress", "lz4"},
                          {"c.plait", "--compress", "zstd:99"},
                          {"c.plait", "--compress", ""},
                          {"c.plait", "--compress", "position="},
                          {"c.plait", "--compress", "shuffle+hierarchy,lz4"},
                          {"c.plait", "--compress", "hierarchy:cubic,lz4"},
                          {"mesh.ply", "--force"},
                          {"c.plait", "--block", "3000"}}) {
    CAPTURE(options);
    CHECK(here.plait({"convert", "s.plait"}, options).status == 2);
    CHECK(here.names() == before);
  }
}

TEST_CASE("Force_WhenTheNewStoreFails_KeepsTheOldOne") {
  const StoreWorkplace here;
  here.must_subdivide("s.plait", {});
  const std::string expected = here.digest("s.plait");
  CHECK(here.subdivide("s.plait", {}).status == 2);
  CHECK(here.subdivide("s.plait", {"--force", "--memory", "64K"}).status != 0);
  CHECK(here.subdivide("s.plait", {"--force", "--limit", "--scheme", "midpoint"}).status == 2);
  CHECK(here.digest("s.plait") == expected);
  CHECK(here.names() == Words{"mesh.ply", "s.plait"});

  here.must_subdivide("s.plait", {"--force", "--scheme", "midpoint"});
  CHECK(here.digest("s.plait") != expected);
  CHECK(here.names() == Words{"mesh.ply", "s.plait"});
}

}  // namespace plait::test
