// Candidates, and what a sample of real stores says of them. Times are not tested.
#include "tune/sample.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdint>
#include <random>

#include "paging/level_cursor.h"
#include "plait/compression.h"
#include "plait/error.h"
#include "plait/extend/copy_levels.h"
#include "plait/extend/store_access.h"
#include "plait/registry.h"
#include "plait/subdivide.h"
#include "support/temporary_directory.h"
#include "support/test_meshes.h"

namespace plait::tune {
namespace {

/// A smooth surface with normals.
Store smooth_store(int levels, std::uint64_t block_bytes = 1 << 16) {
  Store store =
      Store::create({}, lay_out(BaseMesh::build(test::random_sphere(3, 200)), LayoutKind::kHilbert),
                    {.backend = "memory", .block_bytes = block_bytes}, default_backends());
  add_base_positions(store);
  subdivide(store, {.executor = ExecutorKind::kFused, .levels = levels, .normals = true});
  return store;
}

/// Gives every record of an attribute random bits.
void fill_with_random_bits(Store& store, AttributeId id) {
  std::mt19937_64 random(11);
  for (int level = store.base_level() + 1; level <= store.attributes()[id].finest_level; ++level) {
    LevelCursor cursor(StoreAccess::open_session(store), StoreAccess::level_file(store, id, level),
                       Access::kOverwrite);
    for (EdgeId edge = 0; edge < store.base().edge_count(); ++edge)
      for (std::byte& byte : cursor.slot(edge).bytes) byte = static_cast<std::byte>(random());
  }
}

bool contains(const std::vector<Pipeline>& all, const Pipeline& one) {
  return std::ranges::find(all, one) != all.end();
}
bool has_filter(const Pipeline& pipeline, std::string_view name) {
  return std::ranges::find(pipeline.filters, name, &PipelineStage::name) != pipeline.filters.end();
}
bool always() { return true; }

Sample sample_of(const Store& store, std::uint64_t most_bytes, const Proceed& proceed = always) {
  const test::TemporaryDirectory directory{test::Medium::kMemory};
  Sample sample = take_sample(store, most_bytes, directory.path(), Reads::kWarmOnly,
                              default_pipelines(), proceed);
  CHECK(std::filesystem::is_empty(directory.path()));
  return sample;
}

CopyRun run_of(Store& store, const Choice& choice) {
  const test::TemporaryDirectory directory{test::Medium::kMemory};
  return store_and_read(store, choice, directory.path() / "copy.plait", Reads::kCold,
                        default_backends(), always);
}

}  // namespace

TEST_CASE("Candidates_BeginWithNoneAndPresets_AndSuitTheType") {
  const auto floats = candidate_pipelines(default_pipelines(), {"position"});
  REQUIRE(floats.size() > 10);
  CHECK(floats[0] == "none");
  CHECK(floats[1] == preset_pipeline("fast", {"position"}));
  CHECK(floats[2] == preset_pipeline("default", {"position"}).without_predicted_stage());
  CHECK(floats[3] == preset_pipeline("small", {"position"}).without_predicted_stage());
  for (const char* expected : {"lz4", "zstd:9", "shuffle,lz4", "columns,bitpack",
                               "columns+shuffle,zstd:3", "normals+shuffle,zstd:1"})
    CHECK(contains(floats, expected));
  for (const Pipeline& pipeline : floats) CHECK(std::ranges::count(floats, pipeline) == 1);
  const auto whole = candidate_pipelines(default_pipelines(), {"label", ComponentType::kUint32, 1});
  CHECK(contains(whole, "shuffle,lz4"));
  for (const Pipeline& pipeline : whole) CHECK(!has_filter(pipeline, "columns"));
  // A single byte has nothing to group.
  const auto bytes = candidate_pipelines(default_pipelines(), {"flag", ComponentType::kUint8, 1});
  CHECK(contains(bytes, "lz4"));
  CHECK(!contains(bytes, "shuffle,lz4"));
}

TEST_CASE("Candidates_OfRoundedRecords_CountInSteps") {
  const auto rounded = candidate_pipelines(default_pipelines(), {"position"}, 0.25);
  for (const char* expected : {"hierarchy+shuffle,zstd:1", "hierarchy:step=0.25+shuffle,zstd:1",
                               "lattice:0.25+columns+shuffle,lz4"})
    CHECK(contains(rounded, expected));
  for (const Pipeline& pipeline : candidate_pipelines(default_pipelines(), {"position"}))
    CHECK(!has_filter(pipeline, "lattice"));
}

TEST_CASE("Candidates_HaveCodecsAndFiltersOfPlugins") {
  PipelineRegistry registry = default_pipelines();
  registry.add(RegisteredCodec{
      "mine", "", [](std::string_view) { return default_pipelines().make_codec({"none"}); }});
  registry.add(RegisteredFilter{
      "turn", "", [](std::string_view, const FilterLevel& level) {
        return std::move(default_pipelines().open("shuffle,none", level).filters.front());
      }});
  const auto pipelines = candidate_pipelines(registry, {"position"});
  for (const char* expected : {"mine", "shuffle,mine", "turn,lz4", "turn+shuffle,mine"})
    CHECK(contains(pipelines, expected));
}

TEST_CASE("Sample_OfASmallStore_StoresWhatTheWholeStores") {
  Store store = smooth_store(3);
  const Sample sample = sample_of(store, 1 << 30);
  CHECK(sample.is_complete);
  CHECK(sample.bytes == raw_bytes(store));
  // Of a surface without rounding, only positions are no normals.
  for (const auto& [why, pipelines] : sample.refused) {
    CAPTURE(why, pipelines);
    for (const std::string& each : pipelines) CHECK(each.starts_with("position=normals"));
  }
  const CopyRun fast = run_of(store, choice_of_preset("fast", "pread"));
  for (std::size_t at = 0; at < 2; ++at) {
    const auto same = std::ranges::find(sample.pipelines[at], Pipeline("columns,bitpack"),
                                        &SampledPipeline::pipeline);
    REQUIRE(same != sample.pipelines[at].end());
    CHECK(same->part.stored_bytes == fast.parts[at].stored_bytes);
    CHECK(same->can_change);
  }
  CHECK(std::ranges::any_of(sample.pipelines[0],
                            [](const SampledPipeline& one) { return !one.can_change; }));
}

TEST_CASE("Sample_OfALargeStore_IsItsCoarserLevels") {
  const Store store = smooth_store(4);
  const Sample sample = sample_of(store, raw_bytes(store) - 1);
  CHECK(sample.bytes < raw_bytes(store) / 3);
  CHECK(sample.bytes > raw_bytes(store) / 5);
}

TEST_CASE("Sample_ThatIsCancelled_SaysSo") {
  int calls = 0;
  const Sample sample = sample_of(smooth_store(3), 1 << 30, [&] { return ++calls < 60; });
  CHECK(!sample.is_complete);
}

TEST_CASE("Sample_OfNormalsWithoutPositions_SaysWhatIsRefused") {
  Store store = smooth_store(2);
  store.remove_attribute(store.attribute("position"));
  const Sample sample = sample_of(store, 1 << 30);
  REQUIRE(sample.attributes.size() == 1);
  REQUIRE(sample.refused.size() == 1);
  CHECK(sample.refused.begin()->first.find("normals") != std::string::npos);
  CHECK(std::ranges::count(sample.refused.begin()->second, "normal=normals+shuffle,zstd:1") == 1);
  for (const SampledPipeline& one : sample.pipelines[0])
    CHECK(!has_filter(one.pipeline, "normals"));
}

TEST_CASE("Dominated_IsWhatAnotherBeatsInEverything") {
  const auto with = [](double bytes, double write, double read) {
    return SampledPipeline{"none",
                           {.stored_bytes = bytes, .write_seconds = write, .warm_seconds = read}};
  };
  CHECK(not_dominated({with(1, 9, 9), with(9, 1, 9), with(9, 2, 9), with(9, 9, 1),
                       with(10, 10, 10)}) == std::vector<std::size_t>{0, 1, 3});
}

TEST_CASE("Proposals_AreNew_AndFewerBytesForSize") {
  Store store = smooth_store(3);
  fill_with_random_bits(store, 1);
  const Sample sample = sample_of(store, 1 << 30);
  std::vector<Measured> measured;
  for (const char* preset : {"none", "fast", "default", "small"})
    measured.push_back(
        {choice_of_preset(preset, "pread"), {run_of(store, choice_of_preset(preset, "pread"))}});
  // Nothing is smaller than the positions that the scheme makes and the raw normals.
  const std::vector<Choice> proposed = propose(sample, measured, Goal::kSize, 2);
  REQUIRE(proposed.size() == 2);
  CHECK(proposed[0] != proposed[1]);
  CHECK(proposed[0].compress[0].find("position=predicted") == 0);
  for (const Choice& choice : proposed)
    CHECK(run_of(store, choice).stored_bytes <= 1.01 * measured[2].stored_bytes());
}

TEST_CASE("Copy_OfAChoice_IsWhatItsOptionsMake") {
  Store store = smooth_store(3);
  const CopyRun made = run_of(store, choice_of_preset("default", "pread"));
  CHECK(made.parts[1].made_blocks == made.parts[1].blocks);
  const CopyRun none = run_of(store, choice_of_preset("none", "pread"));
  CHECK(none.parts[1].made_blocks == 0);
  CHECK(none.stored_bytes > 5 * made.stored_bytes);
  CHECK(choice_of_preset("none", "pread").options() == "--backend pread");
  CHECK(choice_of_preset("none", "mmap").options() == "--backend mmap");
  CHECK(choice_of_preset("small", "pread").options() == "--compress small");
  const std::vector<AttributeSchema> attributes = {{"position"}, {"normal"}};
  CHECK(choice_of_pipelines(attributes, {"lz4", "none"}).options() ==
        "--compress position=lz4 --compress normal=none");
}

}  // namespace plait::tune
