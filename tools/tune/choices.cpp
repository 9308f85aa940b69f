#include "tune/choices.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <set>

#include "plait/backends/compression.h"
#include "plait/block_maker.h"
#include "tune/front.h"

namespace plait::tune {
namespace {

double at(const Figure& figure, Bound bound) {
  return bound == Bound::kLow ? figure.low : bound == Bound::kHigh ? figure.high : figure.value;
}

/// Size, time to encode, time to decode, and whether the records stay as they are.
using TotalCosts = std::array<double, 4>;

struct Combination {
  Choice choice;
  TotalCosts costs = {};
};

/// Only those that no other one beats.
std::vector<Combination> best_of(const std::vector<Combination>& all) {
  std::vector<Costs> costs;
  costs.reserve(all.size());
  for (const Combination& one : all) costs.emplace_back(one.costs.begin(), one.costs.end());
  std::vector<Combination> best;
  for (const std::size_t index : pareto_front(costs)) best.push_back(all[index]);
  return best;
}

/// So that stores of many attributes take no longer: the choices next to each other differ little.
std::vector<Combination> thinned(std::vector<Combination> all) {
  constexpr std::size_t kMost = 500;
  if (all.size() <= kMost) return all;
  std::vector<Combination> some;
  for (std::size_t i = 0; i < kMost; ++i) some.push_back(all[i * (all.size() - 1) / (kMost - 1)]);
  return some;
}

}  // namespace

bool stores_raw(const Trials& trials, const Choice& choice) {
  return std::ranges::all_of(choice.trials,
                             [&](std::size_t at) { return trials.trials[at].pipeline == "none"; });
}

bool was_probed(const Trials& trials, const Choice& choice) {
  return std::ranges::any_of(trials.corrections, [&](const ReadCorrection& correction) {
    return correction.trials == choice.trials;
  });
}

namespace {

/// That of the choice itself, or else of another one with the same pipeline of this attribute.
double read_factor(const Trials& trials, const Choice& choice, std::size_t id) {
  if (trials.corrections.empty()) return 1;
  const bool raw = stores_raw(trials, choice);
  double factor = 1;
  for (const ReadCorrection& correction : trials.corrections) {
    if (correction.trials == choice.trials) return correction.factors[id];
    if (correction.stores_raw == raw && id < correction.trials.size() &&
        correction.trials[id] == choice.trials[id])
      factor = correction.factors[id];
  }
  return factor;
}

}  // namespace

std::vector<Work> work_of(const Trials& trials, const Choice& choice, Bound bound,
                          std::optional<LeftOut> without) {
  std::vector<Work> works;
  for (std::size_t id = 0; id < choice.trials.size(); ++id) {
    const Trial& trial = trials.trials[choice.trials[id]];
    const Rates rates =
        rates_of(trials, trial,
                 without && without->attribute == id ? std::optional(without->part) : std::nullopt);
    const double raw = trials.attributes[id].raw_bytes;
    const double stored = at(rates.stored, bound), decode = at(rates.decode, bound);
    works.push_back({raw * stored, raw * at(rates.encode, bound), raw * decode,
                     trial.finest_block_bytes * stored, trial.finest_block_bytes * decode,
                     trial.needs_other_blocks || trial.is_predicted,
                     read_factor(trials, choice, id)});
  }
  return works;
}

std::vector<std::uint64_t> block_sizes(const Trials& trials) {
  std::set<std::uint64_t> sizes;
  for (const Trial& trial : trials.trials) sizes.insert(trial.block_bytes);
  return {sizes.begin(), sizes.end()};
}

std::vector<Choice> worthwhile_choices(const Trials& trials) {
  std::vector<Choice> choices;
  for (const std::uint64_t block_bytes : block_sizes(trials)) {
    std::vector<Combination> combinations = {{{block_bytes, {}}, {}}};
    for (std::size_t id = 0; id < trials.attributes.size(); ++id) {
      std::vector<Combination> own;
      for (std::size_t i = 0; i < trials.trials.size(); ++i) {
        const Trial& trial = trials.trials[i];
        if (trial.attribute != id || trial.block_bytes != block_bytes || !is_measured(trial))
          continue;
        const Work work = work_of(trials, {block_bytes, std::vector(id + 1, i)}).back();
        own.push_back({{block_bytes, {i}},
                       {work.stored_bytes, work.encode_seconds, work.decode_seconds,
                        work.is_fixed ? 1.0 : 0.0}});
      }
      std::vector<Combination> longer;
      for (const Combination& one : combinations)
        for (const Combination& next : best_of(own)) {
          Combination both = one;
          both.choice.trials.push_back(next.choice.trials.front());
          for (std::size_t i = 0; i < both.costs.size(); ++i) both.costs[i] += next.costs[i];
          both.costs.back() = std::min(both.costs.back(), 1.0);
          longer.push_back(std::move(both));
        }
      combinations = thinned(best_of(longer));
    }
    for (Combination& one : combinations)
      if (one.choice.trials.size() == trials.attributes.size() && !one.choice.trials.empty())
        choices.push_back(std::move(one.choice));
  }
  return choices;
}

std::optional<Choice> choice_with(const Trials& trials, std::uint64_t block_bytes,
                                  const std::vector<std::string>& pipelines) {
  Choice choice{block_bytes, {}};
  for (std::size_t id = 0; id < trials.attributes.size(); ++id) {
    const auto with = [&](const std::string& pipeline) {
      return std::ranges::find_if(trials.trials, [&](const Trial& trial) {
        return trial.attribute == id && trial.block_bytes == block_bytes &&
               trial.pipeline == pipeline && is_measured(trial);
      });
    };
    auto found = with(pipelines[id]);
    // Where no block is predicted, the stage changes nothing and is not tried.
    if (found == trials.trials.end()) found = with(without_predicted_stage(pipelines[id]));
    if (found == trials.trials.end()) return std::nullopt;
    choice.trials.push_back(static_cast<std::size_t>(found - trials.trials.begin()));
  }
  return choice;
}

std::optional<Choice> preset_choice(const Trials& trials, std::uint64_t block_bytes,
                                    std::string_view preset) {
  std::vector<std::string> pipelines;
  for (const SampledAttribute& attribute : trials.attributes)
    pipelines.push_back(preset_pipeline(preset, attribute.schema));
  return choice_with(trials, block_bytes, pipelines);
}

std::string size_argument(std::uint64_t bytes) {
  constexpr std::uint64_t kMebi = 1 << 20, kKibi = 1 << 10;
  if (bytes % kMebi == 0) return fmt::format("{}MiB", bytes / kMebi);
  if (bytes % kKibi == 0) return fmt::format("{}KiB", bytes / kKibi);
  return fmt::format("{}", bytes);
}

std::string to_text(const Trials& trials, const Choice& choice) {
  const auto pipeline = [&](std::size_t id) -> const std::string& {
    return trials.trials[choice.trials[id]].pipeline;
  };
  bool all_same = true;
  for (std::size_t id = 1; id < choice.trials.size(); ++id)
    all_same = all_same && pipeline(id) == pipeline(0);
  std::string text = all_same ? pipeline(0) : "";
  if (!all_same)
    for (std::size_t id = 0; id < choice.trials.size(); ++id)
      text += fmt::format("{}{}={}", id == 0 ? "" : " ", trials.attributes[id].schema.name,
                          pipeline(id));
  return fmt::format("{} in blocks of {}", text, size_argument(choice.block_bytes));
}

}  // namespace plait::tune
