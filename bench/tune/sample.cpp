#include "tune/sample.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "plait/error.h"
#include "plait/registry.h"

namespace plait::tune {
namespace {

/// [attribute]; those that have no pipeline left are stored with `none`.
using Together = std::vector<std::optional<Pipeline>>;

/// Adds what each attribute of the sample takes with its pipeline. If one of them refuses the
/// records, it adds nothing and returns why.
std::optional<std::string> try_together(const Together& pipelines, const Run& store,
                                        Sample& sample) try {
  std::vector<Pipeline> all;
  all.reserve(pipelines.size());
  for (const auto& pipeline : pipelines) all.push_back(pipeline.value_or(Pipeline()));
  const CopyRun run = store(choice_of_pipelines(sample.attributes, all));
  for (std::size_t at = 0; at < pipelines.size(); ++at)
    if (pipelines[at])
      sample.pipelines[at].push_back({*pipelines[at], run.parts[at], run.can_change});
  return std::nullopt;
} catch (const Error& error) {
  if (!is_refusal(error)) throw;
  return error.what();
}

/// Pipelines of some attributes, with what these attributes cost as a whole.
struct Priced {
  double cost = 0;
  std::vector<Pipeline> pipelines = {};
};

CopyFigures scaled(const CopyFigures& part, const CopyFigures& sampled, const CopyFigures& whole) {
  CopyFigures result = part;
  for (const auto figure :
       {&CopyFigures::stored_bytes, &CopyFigures::write_seconds, &CopyFigures::warm_seconds})
    if (sampled.*figure > 0) result.*figure *= whole.*figure / (sampled.*figure);
  return result;
}

/// What each pipeline of an attribute would cost, the least first.
std::vector<Priced> priced(const Sample& sample, std::size_t attribute,
                           const std::vector<Measured>& measured, Goal goal) {
  const auto& sampled = sample.pipelines[attribute];
  const CopyRun& none = measured.front().runs.front();
  std::vector<Priced> all;
  const auto add = [&](const Pipeline& pipeline, CopyFigures part, bool can_change) {
    if (goal == Goal::kUpdate && !can_change) return;
    // Seconds of disk and processors overlap.
    part.write_seconds =
        std::max(part.stored_bytes / none.stored_bytes * none.write_seconds, part.write_seconds);
    part.read_seconds =
        std::max(part.stored_bytes / none.stored_bytes * none.read_seconds, part.warm_seconds);
    all.push_back({cost(goal, part), {pipeline}});
  };
  // How much the whole is beside the sample: as a measured pipeline says that both have.
  const CopyFigures *of_sample = nullptr, *of_whole = nullptr;
  for (const Measured& one : measured) {
    if (one.choice.compress.empty()) continue;
    const Pipeline pipeline = pipeline_of(one.choice, sample.attributes[attribute]);
    const CopyFigures& part = one.runs.front().parts[attribute];
    add(pipeline, part, one.runs.front().can_change);
    const auto same = std::ranges::find(sampled, pipeline, &SampledPipeline::pipeline);
    if (same == sampled.end() || part.made_blocks > 0 || of_sample != nullptr) continue;
    of_sample = &same->part;
    of_whole = &part;
  }
  if (of_sample != nullptr)
    for (const std::size_t at : not_dominated(sampled))
      add(sampled[at].pipeline, scaled(sampled[at].part, *of_sample, *of_whole),
          sampled[at].can_change);
  std::ranges::stable_sort(all, {}, &Priced::cost);
  return all;
}

}  // namespace

std::vector<std::size_t> not_dominated(const std::vector<SampledPipeline>& pipelines) {
  const auto beats = [](const CopyFigures& a, const CopyFigures& b) {
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
  const BackendRegistry backends = default_backends(registry);
  Store coarse = coarse_levels_in_memory(source, most_bytes, backends);
  Sample sample;
  sample.bytes = raw_bytes(coarse);
  std::vector<std::vector<Pipeline>> candidates;
  std::size_t most = 0;
  for (const AttributeId id : refined_attributes(source)) {
    const auto& schema = sample.attributes.emplace_back(source.attributes()[id].schema);
    const auto& rounding = StoreAccess::rounding(source, id);
    candidates.push_back(candidate_pipelines(
        registry, schema,
        rounding && rounding->step > 0 ? std::optional(rounding->step) : std::nullopt));
    most = std::max(most, candidates.back().size());
  }
  sample.pipelines.resize(sample.attributes.size());
  const Run store = [&](const Choice& choice) {
    return store_and_read(coarse, choice, directory / "sample.plait", reads, backends, proceed);
  };
  try {
    for (std::size_t i = 0; i < most; ++i) {
      Together together(candidates.size());
      for (std::size_t at = 0; at < candidates.size(); ++at)
        if (i < candidates[at].size()) together[at] = candidates[at][i];
      if (!try_together(together, store, sample)) continue;
      // One of them refuses what the others would take.
      for (std::size_t at = 0; at < together.size(); ++at) {
        if (!together[at]) continue;
        Together alone(together.size());
        alone[at] = together[at];
        if (const auto why = try_together(alone, store, sample))
          sample.refused[*why].push_back(
              fmt::format("{}={}", sample.attributes[at].name, together[at]->to_text()));
      }
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
  std::vector<Priced> combinations(1);
  for (std::size_t at = 0; at < sample.attributes.size(); ++at) {
    auto all = priced(sample, at, measured, goal);
    all.resize(std::min(all.size(), kOfAttribute));
    std::vector<Priced> longer;
    for (const Priced& combination : combinations)
      for (const Priced& one : all) {
        Priced& both = longer.emplace_back(combination);
        both.cost += one.cost;
        both.pipelines.push_back(one.pipelines.front());
      }
    combinations = std::move(longer);
  }
  std::ranges::stable_sort(combinations, {}, &Priced::cost);
  std::vector<Choice> proposed;
  for (const Priced& combination : combinations) {
    const Choice choice = choice_of_pipelines(sample.attributes, combination.pipelines);
    const bool is_measured = std::ranges::any_of(measured, [&](const Measured& one) {
      return store_alike(one.choice, choice, sample.attributes);
    });
    if (proposed.size() < most && !is_measured) proposed.push_back(choice);
  }
  return proposed;
}

}  // namespace plait::tune
