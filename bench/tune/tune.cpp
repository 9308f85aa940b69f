#include "tune/tune.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/stopwatch.h"
#include "instrument/disk.h"
#include "instrument/scratch_directory.h"
#include "plait/compression.h"
#include "plait/error.h"
#include "plait/registry.h"

namespace plait::tune {
namespace {

/// Of the time, for the sample.
constexpr double kSampleShare = 0.3;
constexpr std::uint64_t kSampleBytes = 8u << 20;

std::vector<Choice> presets(const std::string& raw_backend) {
  std::vector<Choice> choices = {choice_of_preset("none", raw_backend)};
  for (const CompressionPreset& preset : compression_presets())
    if (preset.name != "none")
      choices.push_back(choice_of_preset(std::string(preset.name), raw_backend));
  return choices;
}

/// The presets that store what others make again from other blocks, so that they make it again too.
/// Says in `notes` how much of it is made again.
std::vector<Choice> made_again(const std::vector<Measured>& measured,
                               const std::vector<AttributeSchema>& attributes,
                               std::vector<std::string>& notes) {
  std::vector<AttributeSchema> again;  // most of their blocks are equal
  for (std::size_t at = 0; at < attributes.size(); ++at) {
    const auto maker = std::ranges::find_if(measured, [&](const Measured& one) {
      return pipeline_of(one.choice, attributes[at]).has_predicted_stage();
    });
    if (maker == measured.end()) continue;
    const CopyFigures& part = maker->runs.front().parts[at];
    notes.push_back(fmt::format(
        "{}: {} of {} blocks equal what is made again bit by bit, and take no bytes with the "
        "presets default and small",
        attributes[at].name, part.made_blocks, part.blocks));
    if (2 * part.made_blocks >= part.blocks) again.push_back(attributes[at]);
  }
  std::vector<Choice> choices;
  for (const Measured& one : measured) {
    if (one.choice.compress.empty()) continue;
    Choice choice = one.choice;
    for (const AttributeSchema& schema : again) {
      Pipeline pipeline = pipeline_of(one.choice, schema);
      if (pipeline.has_predicted_stage()) continue;
      pipeline.recipe = "";
      choice.is_preset = false;
      choice.name += fmt::format(", {} made again", schema.name);
      choice.compress.push_back(fmt::format("{}={}", schema.name, pipeline.to_text()));
    }
    if (!choice.is_preset) choices.push_back(choice);
  }
  return choices;
}

}  // namespace

TuneFindings measure_store(Store& store, const PipelineRegistry& registry,
                           const TuneOptions& options) {
  if (store.finest_level() == store.base_level())
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("tune {}: expected a store with at least one level, found none",
                            store.path().native()));
  const Stopwatch clock;
  TuneFindings findings;
  findings.directory = options.directory;
  findings.goal = options.goal;
  findings.finest_level = store.finest_level();
  findings.raw_bytes = raw_bytes(store);
  findings.block_bytes = store.options().block_bytes;
  const instrument::ScratchDirectory scratch(options.directory);
  // A copy takes at most what the records take, and its tables.
  instrument::require_space(options.directory,
                            findings.raw_bytes + findings.raw_bytes / 8 + (1u << 20));
  const BackendRegistry backends = default_backends(registry);
  std::string phase = "presets";
  const auto proceed = [&] {
    return options.proceed(phase, std::min(clock.seconds() / options.seconds, 1.0));
  };
  const auto run = [&](const Choice& choice) {
    return store_and_read(store, choice, scratch.path() / "copy.plait", Reads::kCold, backends,
                          proceed);
  };

  std::vector<Measured> once;
  // What a user gets who names no backend.
  const BackendChoice raw =
      backends.choose({.path = scratch.path(), .level_bytes = findings.raw_bytes});
  for (const Choice& choice : presets(raw.name)) once.push_back({choice, {run(choice)}});
  phase = "sample";
  // What the presets took says how long a round takes.
  const double seconds_of_choice = clock.seconds() / static_cast<double>(once.size());
  const double end_of_sample =
      std::min(options.seconds, clock.seconds() + kSampleShare * options.seconds);
  bool is_cancelled = false;
  findings.sample =
      take_sample(store, kSampleBytes, scratch.path(), Reads::kWarmOnly, registry, [&] {
        is_cancelled = is_cancelled || !proceed();
        return !is_cancelled && clock.seconds() < end_of_sample;
      });
  if (is_cancelled) throw Error(ErrorCode::kCancelled, "tune: cancelled before the first round");
  for (const Measured& one : once) findings.choices.push_back({one.choice});
  for (const Choice& choice : made_again(once, findings.sample.attributes, findings.notes))
    if (findings.choices.size() < kMostChoices) findings.choices.push_back({choice});
  for (const Choice& choice :
       propose(findings.sample, once, options.goal, kMostChoices - findings.choices.size()))
    findings.choices.push_back({choice});

  phase = "rounds";
  const double seconds_of_round = seconds_of_choice * static_cast<double>(findings.choices.size());
  const instrument::SurroundingsWatch watch;
  if (clock.seconds() + seconds_of_round > options.seconds)
    for (std::size_t at = 0; at < once.size(); ++at) findings.choices[at].runs = once[at].runs;
  else
    findings.is_interrupted = !measure_rounds(
        findings.choices, options.goal, options.seconds, [&] { return clock.seconds(); }, run);
  findings.surroundings = watch.since(0);
  findings.seconds = clock.seconds();
  // The presets alone, which were stored once, are no round.
  const std::size_t rounds = findings.choices.back().runs.size();
  if (rounds < kEnoughRounds && !findings.choices.back().left)
    findings.seconds_for_enough =
        findings.seconds + static_cast<double>(kEnoughRounds - rounds) * seconds_of_round;
  return findings;
}

}  // namespace plait::tune
