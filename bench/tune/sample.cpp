#include "tune/sample.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <utility>

#include "plait/error.h"
#include "plait/registry.h"

namespace plait::tune {
namespace {

/// Stores the sample with a pipeline for each attribute, those that end early with `none`.
class Trier {
 public:
  Trier(Store& source, const std::filesystem::path& directory, Reads reads,
        const PipelineRegistry& registry, const Proceed& proceed, Sample& sample)
      : source_(source),
        path_(directory / "sample.plait"),
        reads_(reads),
        backends_(default_backends(registry)),
        proceed_(proceed),
        sample_(sample) {
    for (const AttributeSchema& schema : sample.attributes) names_.push_back(schema.name);
  }

  void try_together(const std::vector<std::optional<Pipeline>>& pipelines) {
    if (run(pipelines, nullptr)) return;
    // One of them refuses what the others would take.
    for (std::size_t at = 0; at < pipelines.size(); ++at) {
      if (!pipelines[at]) continue;
      std::vector<std::optional<Pipeline>> alone(pipelines.size());
      alone[at] = pipelines[at];
      std::string why;
      if (!run(alone, &why))
        sample_.refused[why].push_back(fmt::format("{}={}", names_[at], pipelines[at]->to_text()));
    }
  }

 private:
  bool run(const std::vector<std::optional<Pipeline>>& pipelines, std::string* why) try {
    std::vector<Pipeline> all;
    all.reserve(pipelines.size());
    for (const auto& pipeline : pipelines) all.push_back(pipeline.value_or(Pipeline()));
    const CopyRun run = store_and_read(source_, choice_of_pipelines(names_, all), path_, reads_,
                                       backends_, proceed_);
    for (std::size_t at = 0; at < pipelines.size(); ++at)
      if (pipelines[at])
        sample_.pipelines[at].push_back({*pipelines[at], run.parts[at], run.can_change});
    return true;
  } catch (const Error& error) {
    if (!is_refusal(error)) throw;
    if (why != nullptr) *why = error.what();
    return false;
  }

  Store& source_;
  std::filesystem::path path_;
  Reads reads_;
  BackendRegistry backends_;
  const Proceed& proceed_;
  Sample& sample_;
  std::vector<std::string> names_;
};

/// Seconds of disk and processors overlap.
double goal_cost(Goal goal, const PartOfCopy& part, double read_speed, double write_speed) {
  return cost(goal, {.stored_bytes = part.stored_bytes,
                     .write_seconds = std::max(part.stored_bytes / write_speed, part.write_seconds),
                     .read_seconds = std::max(part.stored_bytes / read_speed, part.warm_seconds)});
}

/// A pipeline of an attribute with what the whole attribute costs.
struct Priced {
  Pipeline pipeline;
  double cost = 0;
};

PartOfCopy scaled(const PartOfCopy& part, const PartOfCopy& sampled, const PartOfCopy& whole) {
  const auto by = [](double value, double of_sample, double of_whole) {
    return of_sample > 0 ? value * of_whole / of_sample : value;
  };
  return {by(part.stored_bytes, sampled.stored_bytes, whole.stored_bytes),
          by(part.write_seconds, sampled.write_seconds, whole.write_seconds), 0,
          by(part.warm_seconds, sampled.warm_seconds, whole.warm_seconds)};
}

/// What each pipeline of an attribute would cost, the least first.
std::vector<Priced> priced(const Sample& sample, std::size_t attribute,
                           const std::vector<Measured>& measured, Goal goal, double read_speed,
                           double write_speed) {
  const auto& sampled = sample.pipelines[attribute];
  const AttributeSchema& schema = sample.attributes[attribute];
  std::vector<Priced> all;
  // How much the whole is beside the sample: as a measured pipeline says that both have.
  const PartOfCopy *of_sample = nullptr, *of_whole = nullptr;
  for (const Measured& one : measured) {
    if (one.choice.compress.empty()) continue;
    const Pipeline pipeline = pipeline_of(one.choice, schema);
    const PartOfCopy& part = one.runs.front().parts[attribute];
    if (goal != Goal::kUpdate || one.runs.front().can_change)
      all.push_back({pipeline, goal_cost(goal, part, read_speed, write_speed)});
    const auto same = std::ranges::find(sampled, pipeline, &SampledPipeline::pipeline);
    if (same == sampled.end() || part.made_blocks > 0 || of_sample != nullptr) continue;
    of_sample = &same->part;
    of_whole = &part;
  }
  if (of_sample != nullptr)
    for (const std::size_t at : not_dominated(sampled))
      if (goal != Goal::kUpdate || sampled[at].can_change)
        all.push_back(
            {sampled[at].pipeline, goal_cost(goal, scaled(sampled[at].part, *of_sample, *of_whole),
                                             read_speed, write_speed)});
  std::ranges::stable_sort(all, {}, &Priced::cost);
  return all;
}

}  // namespace

std::vector<std::size_t> not_dominated(const std::vector<SampledPipeline>& pipelines) {
  const auto beats = [](const PartOfCopy& a, const PartOfCopy& b) {
    return a.stored_bytes <= b.stored_bytes && a.write_seconds <= b.write_seconds &&
           a.warm_seconds <= b.warm_seconds &&
           (a.stored_bytes < b.stored_bytes || a.write_seconds < b.write_seconds ||
            a.warm_seconds < b.warm_seconds);
  };
  std::vector<std::size_t> places;
  for (std::size_t at = 0; at < pipelines.size(); ++at)
    if (std::ranges::none_of(pipelines, [&](const SampledPipeline& other) {
          return beats(other.part, pipelines[at].part);
        }))
      places.push_back(at);
  return places;
}

Sample take_sample(const Store& source, std::uint64_t most_bytes,
                   const std::filesystem::path& directory, Reads reads,
                   const PipelineRegistry& registry, const Proceed& proceed) {
  Sample sample;
  Store coarse = coarse_levels_in_memory(source, most_bytes, default_backends(registry));
  sample.bytes = raw_bytes(coarse);
  std::vector<std::vector<Pipeline>> candidates;
  std::size_t most = 0;
  for (const AttributeId id : refined_attributes(source)) {
    const auto& schema = sample.attributes.emplace_back(source.attributes()[id].schema);
    const auto& rounding = source.rounding(id);
    candidates.push_back(candidate_pipelines(
        registry, schema,
        rounding && rounding->step > 0 ? std::optional(rounding->step) : std::nullopt));
    most = std::max(most, candidates.back().size());
  }
  sample.pipelines.resize(sample.attributes.size());
  Trier trier(coarse, directory, reads, registry, proceed, sample);
  try {
    for (std::size_t i = 0; i < most; ++i) {
      std::vector<std::optional<Pipeline>> together(candidates.size());
      for (std::size_t at = 0; at < candidates.size(); ++at)
        if (i < candidates[at].size()) together[at] = candidates[at][i];
      trier.try_together(together);
    }
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kCancelled) throw;
    sample.is_complete = false;
  }
  return sample;
}

std::vector<Choice> propose(const Sample& sample, const std::vector<Measured>& measured, Goal goal,
                            std::size_t most) {
  constexpr std::size_t kOfAttribute = 4;
  const CopyRun& none = measured.front().runs.front();
  const double read_speed = none.stored_bytes / none.read_seconds;
  const double write_speed = none.stored_bytes / none.write_seconds;
  std::vector<std::pair<double, std::vector<Pipeline>>> combinations = {{0, {}}};
  for (std::size_t at = 0; at < sample.attributes.size(); ++at) {
    auto all = priced(sample, at, measured, goal, read_speed, write_speed);
    all.resize(std::min(all.size(), kOfAttribute));
    std::vector<std::pair<double, std::vector<Pipeline>>> longer;
    for (const auto& [cost, pipelines] : combinations)
      for (const Priced& one : all) {
        longer.emplace_back(cost + one.cost, pipelines).second.push_back(one.pipeline);
      }
    combinations = std::move(longer);
  }
  std::ranges::stable_sort(combinations, {}, [](const auto& each) { return each.first; });
  std::vector<std::string> names;
  for (const AttributeSchema& schema : sample.attributes) names.push_back(schema.name);
  std::vector<Choice> proposed;
  for (const auto& combination : combinations) {
    const Choice choice = choice_of_pipelines(names, combination.second);
    const bool is_measured = std::ranges::any_of(measured, [&](const Measured& one) {
      return store_alike(one.choice, choice, sample.attributes);
    });
    if (proposed.size() < most && !is_measured) proposed.push_back(choice);
  }
  return proposed;
}

}  // namespace plait::tune
