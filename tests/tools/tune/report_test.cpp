// The report of made-up findings.
#include "tune/report.h"

#include <catch2/catch.hpp>

#include "plait/backends/compression.h"
#include "tune/page.h"

namespace plait::tune {
namespace {

Findings findings() {
  Findings made;
  made.input = "<surface>.plait";
  made.command_start = "plait convert surface.plait OUT";
  made.finest_level = 5;
  made.own_block_bytes = 1 << 20;
  made.own_pipelines = {{"shuffle,lz4"}};
  made.disk.disk = {.name = "made up",
                    .read = 1e8,
                    .write = 1e8,
                    .latency = 1e-4,
                    .random_read = 1e8,
                    .is_measured = true};
  made.disk.floors = {{1 << 20, {1e8, 9e7, 1.1e8}, {1e8, 9e7, 1.1e8}}};
  made.disk.runs = 3;
  made.trials.attributes.push_back({{"position"}, 1e9, 2, false});
  const auto add = [&](const char* pipeline, double stored, double nanoseconds) {
    Trial trial{0, 1 << 20, pipeline, 1 << 20, false, {}};
    trial.needs_other_blocks = std::string_view(pipeline).starts_with("hierarchy");
    for (int part = 0; part < 2; ++part)
      trial.outcomes.push_back({1e6, 1e6 * stored, 2e-3 * nanoseconds, 1e-3 * nanoseconds, 1});
    made.trials.trials.push_back(trial);
  };
  add("none", 1, 0.1);
  add("shuffle,lz4", 0.5, 0.5);
  add("shuffle,zstd:9", 0.6, 9);
  add("hierarchy+shuffle,zstd:1", 0.125, 2);
  made.trials.trials.push_back({0, 1 << 20, "lz4", 1 << 20, false, std::vector<Outcome>(2)});
  return made;
}

const nlohmann::ordered_json& row_with(const nlohmann::ordered_json& rows,
                                       const std::string& name) {
  for (const auto& row : rows)
    if (row["names"].get<std::string>().find(name) != std::string::npos) return row;
  FAIL("no row is called " << name);
  return rows;
}

}  // namespace

TEST_CASE("Json_HasWhatTheTableHas") {
  const Findings made = findings();
  const Advice advice = advise(made);
  const nlohmann::ordered_json json = to_json(made, advice);
  const std::string text = to_text(made, advice);
  // The pipeline that was not reached is in neither.
  REQUIRE(json["trials"].size() == 4);
  for (const auto& trial : json["trials"])
    CHECK(text.find(trial["pipeline"].get<std::string>()) != std::string::npos);
  CHECK(json["trials"][1]["ratio"]["value"] == Approx(2));
  CHECK(json["trials"][1]["decode_bytes_a_second"]["value"] == Approx(2e9));
  CHECK(json["trials"][1]["encode_bytes_a_second"]["value"] == Approx(1e9));
  CHECK(json["disk"]["floors"][0]["read"]["low"] == 9e7);
  const auto& pick = row_with(json["choices"], "pick");
  CHECK(pick["pipelines"]["position"] == "hierarchy+shuffle,zstd:1");
  CHECK(pick["seconds"]["read"] == Approx(2));  // 2 ns a byte; the disk takes 1.25 s
  CHECK(pick["seconds"]["update"].is_null());
  CHECK(pick["front"] == true);
  CHECK(pick["next_is_faster_from_bytes_a_second"] == Approx(2.5e8).epsilon(1e-3));
  CHECK(row_with(json["choices"], "as it is")["pipelines"]["position"] == "shuffle,lz4");
  CHECK(row_with(json["choices"], "preset none")["ratio"] == Approx(1));
  CHECK(json["other_disks"].size() == classes_of_disks().size());
  CHECK(text.find("  -  ") != std::string::npos);
  CHECK(text.find(json["advice"].get<std::string>()) != std::string::npos);
  CHECK(text.find(json["command"].get<std::string>()) != std::string::npos);
}

TEST_CASE("Text_OfADiskThatLetsABurstPass_NamesTheBurst") {
  Findings made = findings();
  const auto burst = [&] {
    return to_text(made, advise(made)).find("after a pause, 30 MB at 1.50");
  };
  CHECK(burst() == std::string::npos);
  made.disk.disk.burst_bytes = 3e7;
  made.disk.disk.burst_read = 1.5e9;
  CHECK(burst() != std::string::npos);
}

TEST_CASE("Command_NamesEachAttribute_OrStoresRaw") {
  const Findings made = findings();
  CHECK(command_for(made.trials, {1 << 20, {3}}, "plait convert a OUT") ==
        "plait convert a OUT --backend compressed --block 1MiB --compress "
        "position=hierarchy+shuffle,zstd:1");
  CHECK(command_for(made.trials, {1 << 16, {0}}, "plait convert a OUT") ==
        "plait convert a OUT --backend pread --block 64KiB");
}

TEST_CASE("Rows_ThatDoNotDiffer_SaySo") {
  Findings made = findings();
  made.trials.trials[1] = made.trials.trials[3];
  made.trials.trials[1].pipeline = "shuffle,lz4";
  made.trials.trials[3].pipeline = preset_pipeline("fast", {"position"});
  made.trials.trials[1].needs_other_blocks = false;
  const Advice advice = advise(made);
  CHECK(to_text(made, advice).find("no difference from the pick") != std::string::npos);
}

TEST_CASE("Page_RefersToNothingOutside_AndEscapesNames") {
  const Findings made = findings();
  const Advice advice = advise(made);
  std::string page = to_html(made, advice);
  // The name of SVG looks like an address; nothing is fetched from there.
  constexpr std::string_view kNameOfSvg = "http://www.w3.org/2000/svg";
  for (std::size_t at = 0; (at = page.find(kNameOfSvg)) != std::string::npos;)
    page.erase(at, kNameOfSvg.size());
  CHECK(page.find("<surface>") == std::string::npos);
  CHECK(page.find("http://") == std::string::npos);
  CHECK(page.find("https://") == std::string::npos);
  CHECK(page.find("src=") == std::string::npos);
  CHECK(page.find("&lt;surface&gt;") != std::string::npos);
  CHECK(page.find("id=\"tune\"") != std::string::npos);
  CHECK(page.find("hierarchy+shuffle,zstd:1") != std::string::npos);
}

}  // namespace plait::tune
