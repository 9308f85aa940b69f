// The trials of real stores. Sizes are facts; times are not tested.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "plait/backends/compression.h"
#include "plait/block_maker.h"
#include "plait/copy_levels.h"
#include "plait/error.h"
#include "plait/rounding.h"
#include "tools/tune/test_stores.h"
#include "tune/block_trial.h"
#include "tune/candidates.h"
#include "tune/pick.h"
#include "tune/round_robin.h"

namespace plait::tune {
namespace {

bool contains(const std::vector<std::string>& all, const std::string& one) {
  return std::ranges::find(all, one) != all.end();
}

struct Tried {
  Trials trials;
  std::size_t rounds = 0;
};

Tried try_store(const Store& store, std::vector<std::uint64_t> sizes,
                const std::function<bool(const TrialProgress&)>& proceed, int visits = 1) {
  std::vector<std::unique_ptr<BlockGrid>> grids;
  for (const std::uint64_t size : sizes) grids.push_back(std::make_unique<BlockGrid>(store, size));
  StoreBytes bytes(store, 32 << 20);
  const Sample sample = take_sample(bytes, *grids.back(), 4, 1, [] { return true; });
  Tried tried{plan_trials(store, default_pipelines(), grids, sample), 0};
  tried.rounds = measure_in_turn(store, default_pipelines(), bytes, grids, sample, visits,
                                 tried.trials, proceed);
  return tried;
}

bool always_true(const TrialProgress&) { return true; }

/// Times as on any machine, so that only sizes decide.
void make_up_times(Trials& trials) {
  for (Trial& trial : trials.trials)
    for (Outcome& part : trial.outcomes)
      part.encode_seconds = part.decode_seconds = trial.pipeline == "none" ? 1e-9 : 1e-8;
}

Machine trial_machine() {
  return {{.name = "made up",
           .read = 1e8,
           .write = 1e8,
           .latency = 1e-4,
           .random_read = 1e8,
           .is_measured = true},
          2,
          {}};
}

}  // namespace

TEST_CASE("Candidates_BeginWithNoneAndPresets_AndSuitTheType") {
  const auto floats = candidate_pipelines(default_pipelines(), {"position"});
  REQUIRE(floats.size() > 10);
  CHECK(floats[0] == "none");
  CHECK(floats[1] == preset_pipeline("fast", {"position"}));
  CHECK(floats[2] == without_predicted_stage(preset_pipeline("default", {"position"})));
  CHECK(floats[3] == without_predicted_stage(preset_pipeline("small", {"position"})));
  for (const char* expected : {"lz4", "zstd:9", "shuffle,lz4", "shuffle+bytedelta,zstd:1",
                               "lorenzo+shuffle,zstd:3", "normals+shuffle,zstd:1"})
    CHECK(contains(floats, expected));
  for (std::size_t i = 0; i < floats.size(); ++i) CHECK(std::ranges::count(floats, floats[i]) == 1);
  const auto whole = candidate_pipelines(default_pipelines(), {"label", ComponentType::kUint32, 1});
  CHECK(whole[0] == "none");
  CHECK(contains(whole, "shuffle,lz4"));
  for (const std::string& pipeline : whole) {
    CHECK(pipeline.find("parallelogram") == std::string::npos);
    CHECK(pipeline.find("normals") == std::string::npos);
  }
  // A single byte has nothing to group.
  const auto bytes = candidate_pipelines(default_pipelines(), {"flag", ComponentType::kUint8, 1});
  CHECK(contains(bytes, "lz4"));
  CHECK(!contains(bytes, "shuffle,lz4"));
}

TEST_CASE("Candidates_WithAScheme_HaveTheStagePredicted") {
  const auto plain = candidate_pipelines(default_pipelines(), {"position"});
  for (const std::string& pipeline : plain) CHECK(!has_predicted_stage(pipeline));
  const auto made = candidate_pipelines(default_pipelines(), {"position"}, true);
  CHECK(std::equal(plain.begin(), plain.end(), made.begin()));
  CHECK(contains(made, preset_pipeline("default", {"position"})));
  CHECK(contains(made, "predicted+columns,bitpack"));
}

TEST_CASE("Candidates_OfRoundedRecords_CountInSteps") {
  const auto rounded = candidate_pipelines(default_pipelines(), {"position"}, false, 0.25);
  for (const char* expected : {"hierarchy+shuffle,zstd:1", "hierarchy:step=0.25+shuffle,zstd:1",
                               "lattice:0.25+lorenzo+shuffle,lz4"})
    CHECK(contains(rounded, expected));
  for (const std::string& pipeline : candidate_pipelines(default_pipelines(), {"position"})) {
    CHECK(pipeline.find("step") == std::string::npos);
    CHECK(pipeline.find("lattice") == std::string::npos);
  }
}

TEST_CASE("Candidates_HaveCodecsAndFiltersOfPlugins") {
  PipelineRegistry registry = default_pipelines();
  registry.add(PipelineRegistry::CodecEntry{
      "mine", "", [](std::string_view) { return default_pipelines().make_codec("none"); }});
  registry.add(PipelineRegistry::FilterEntry{
      "turn", "", [](std::string_view, const FilterLevel& level) {
        return std::move(default_pipelines().make("shuffle,none", level).filters.front());
      }});
  const auto pipelines = candidate_pipelines(registry, {"position"});
  for (const char* expected : {"mine", "shuffle,mine", "turn,lz4", "turn+shuffle,mine"})
    CHECK(contains(pipelines, expected));
}

TEST_CASE("Candidates_OfBlockSizes_HaveTheStoresOwn") {
  CHECK(candidate_block_sizes(1 << 20) == std::vector<std::uint64_t>{64 << 10, 256 << 10, 1 << 20});
  CHECK(candidate_block_sizes(4096).front() == 4096);
  CHECK(candidate_block_sizes(4 << 20).back() == 4 << 20);
}

TEST_CASE("Trials_OfEveryPipeline_StoreWhatTheBackendStores") {
  // The sample is the whole store, so the sizes must be those of a store that was made so.
  Store store = smooth_store(4);
  const Tried tried = try_store(store, {4096, 65536}, always_true);
  CHECK(tried.trials.attributes.size() == 2);
  for (const char* pipeline : {"none", "shuffle,lz4", "lorenzo+shuffle,zstd:3",
                               "hierarchy+shuffle,zstd:1", "normals+shuffle,zstd:1"}) {
    const auto found = std::ranges::find_if(tried.trials.trials, [&](const Trial& trial) {
      return trial.pipeline == pipeline && trial.attribute == 1 && trial.block_bytes == 65536;
    });
    CAPTURE(pipeline);
    REQUIRE(found != tried.trials.trials.end());
    CHECK(found->needs_other_blocks == (std::string_view(pipeline).starts_with("h") ||
                                        std::string_view(pipeline).starts_with("normals")));
    REQUIRE(tried.trials.attributes[1].parts == 4);
    for (const Outcome& part : found->outcomes) CHECK(part.visits == 1);
  }
}

TEST_CASE("Trials_OfASchemesLevels_TakeTheTableOnly") {
  const Store store = smooth_store(3);
  const Tried tried = try_store(store, {4096, 65536}, always_true);
  int found = 0;
  for (const Trial& trial : tried.trials.trials) {
    CHECK(trial.is_predicted == has_predicted_stage(trial.pipeline));
    if (!trial.is_predicted) continue;
    ++found;
    for (const Outcome& part : trial.outcomes) {
      CHECK(part.stored_bytes <= 24 * std::ceil(part.raw_bytes / 2048));
      CHECK(part.decode_seconds > 0);
    }
  }
  CHECK(found >= 8);
}

TEST_CASE("Trials_OfLevelsThatNoSchemeMakes_HaveNoStagePredicted") {
  Store store = smooth_store(3);
  fill_with_random_bits(store, 0);
  const Tried tried = try_store(store, {65536}, always_true);
  for (const Trial& trial : tried.trials.trials)
    if (trial.attribute == 0) CHECK(!trial.is_predicted);
  CHECK(std::ranges::any_of(tried.trials.trials, &Trial::is_predicted));  // the normals
}

TEST_CASE("Trials_OfARoundedStore_CountInItsSteps") {
  Store store = smooth_store(3);
  Store rounded = Store::create({}, store.base(), store.options(), default_backends());
  ErrorBounds bounds;
  bounds.add("1e-4rel");
  copy_levels(store, rounded, {}, bounds);
  const Tried tried = try_store(rounded, {65536}, always_true);
  const auto size_of = [&](std::string_view start) {
    double least = 1;
    for (const Trial& trial : tried.trials.trials)
      if (trial.attribute == 0 && trial.pipeline.starts_with(start))
        least = std::min(least, rates_of(tried.trials, trial).stored.value);
    return least;
  };
  CHECK(size_of("hierarchy:step=") < 0.7 * size_of("hierarchy+"));
  CHECK(size_of("predicted") == 1);
}

TEST_CASE("Trials_OfNormalsWithoutPositions_AreLeftOut") {
  Store store = smooth_store(2);
  store.remove_attribute(store.attribute("position"));
  const Tried tried = try_store(store, {65536}, always_true);
  REQUIRE(tried.trials.attributes.size() == 1);
  for (const Trial& trial : tried.trials.trials) {
    CHECK(trial.pipeline.find("normals") == std::string::npos);
    CHECK(is_measured(trial));
  }
}

TEST_CASE("Trials_Interrupted_AreFair") {
  const Store store = smooth_store(3);
  for (const std::size_t stop : {std::size_t{0}, std::size_t{5}, std::size_t{150}}) {
    std::size_t calls = 0;
    const Tried tried =
        try_store(store, {4096, 65536}, [&](const TrialProgress&) { return calls++ < stop; });
    std::size_t measured = 0;
    for (const Trial& trial : tried.trials.trials) measured += is_measured(trial);
    CHECK(measured <= stop);
    int fewest = 1000, most = 0;
    for (const Trial& trial : tried.trials.trials) {
      int visits = 0;
      for (const Outcome& part : trial.outcomes) visits += part.visits;
      fewest = std::min(fewest, visits);
      most = std::max(most, visits);
    }
    CHECK(most - fewest <= 1);
    if (stop == 150) {
      CHECK(tried.rounds == stop / tried.trials.trials.size());
    }
  }
}

TEST_CASE("RandomBits_AdviseNone") {
  Store store = smooth_store(3);
  store.remove_attribute(store.attribute("normal"));
  fill_with_random_bits(store, 0);
  Tried tried = try_store(store, {4096, 65536}, always_true);
  make_up_times(tried.trials);
  for (const Goal goal : all_goals()) {
    CAPTURE(to_string(goal));
    const Choice choice = pick(tried.trials, goal, trial_machine());
    CHECK(tried.trials.trials[choice.trials[0]].pipeline == "none");
  }
}

TEST_CASE("ASmoothSurface_ForSize_AdvisesPrediction") {
  const Store store = smooth_store(4);
  Tried tried = try_store(store, {65536}, always_true);
  make_up_times(tried.trials);
  const Choice choice = pick(tried.trials, Goal::kSize, trial_machine());
  CHECK(tried.trials.trials[choice.trials[0]].pipeline.starts_with("predicted+"));
  CHECK(tried.trials.trials[choice.trials[1]].pipeline.starts_with("predicted+"));
  // The same surface, moved: no scheme makes it.
  std::erase_if(tried.trials.trials, &Trial::is_predicted);
  const Choice next = pick(tried.trials, Goal::kSize, trial_machine());
  CHECK(tried.trials.trials[next.trials[0]].pipeline.starts_with("hierarchy"));
  CHECK(tried.trials.trials[next.trials[1]].pipeline.starts_with("normals"));
}

TEST_CASE("StoresWithoutLevels_HaveNoTrials") {
  StoreOptions options;
  options.backend = "memory";
  Store store = Store::create({}, BaseMesh::build(test::octahedron()), options, default_backends());
  CHECK(try_store(store, {65536}, always_true).trials.trials.empty());
  add_base_positions(store);
  CHECK(try_store(store, {65536}, always_true).trials.trials.empty());
  CHECK_THROWS_AS(pick({}, Goal::kRead, trial_machine()), Error);
}

}  // namespace plait::tune
