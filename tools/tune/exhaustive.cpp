#include "tune/exhaustive.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "instrument/statistics.h"
#include "plait/error.h"
#include "plait/machine.h"
#include "plait/stopwatch.h"
#include "tune/choices.h"
#include "tune/scratch_directory.h"
#include "tune/store_copies.h"

namespace plait::tune {
namespace {

/// Choices that together have each pipeline of each attribute, for one size of blocks: the first
/// ones, the second ones, and so on. The first ones are `none`, so these blocks are as they are.
std::vector<Choice> covering_choices(const Trials& trials, std::uint64_t block_bytes) {
  std::vector<std::vector<std::size_t>> of_attribute(trials.attributes.size());
  std::size_t most = 0;
  for (std::size_t at = 0; at < trials.trials.size(); ++at) {
    const Trial& trial = trials.trials[at];
    if (trial.block_bytes != block_bytes || !is_measured(trial)) continue;
    of_attribute[trial.attribute].push_back(at);
    most = std::max(most, of_attribute[trial.attribute].size());
  }
  std::vector<Choice> choices;
  for (std::size_t i = 0; i < most; ++i) {
    Choice choice{block_bytes, {}};
    for (const auto& own : of_attribute)
      if (!own.empty()) choice.trials.push_back(own[i % own.size()]);
    if (choice.trials.size() == trials.attributes.size()) choices.push_back(std::move(choice));
  }
  return choices;
}

/// A choice with its seconds, from the reads of its parts.
struct Rated {
  Choice choice;
  double seconds = 0;
};

/// All combinations of the fastest pipelines of each attribute, and the blocks as they are.
class Combinations {
 public:
  explicit Combinations(const Trials& trials) : trials_(trials) {}

  void add(const Choice& choice, const std::vector<double>& seconds) {
    if (stores_raw(trials_, choice)) {
      rated_.push_back({choice, sum_of(seconds)});
      return;
    }
    for (std::size_t id = 0; id < seconds.size(); ++id) {
      auto& of_attribute = parts_[choice.block_bytes];
      of_attribute.resize(trials_.attributes.size());
      of_attribute[id].emplace_back(seconds[id], choice.trials[id]);
    }
  }

  std::vector<Choice> best(std::size_t most) const {
    constexpr std::size_t kFastest = 3;
    std::vector<Rated> all = rated_;
    for (auto [block_bytes, of_attribute] : parts_) {
      std::vector<Rated> combinations = {{{block_bytes, {}}, 0}};
      for (auto& parts : of_attribute) {
        std::ranges::sort(parts);
        parts.resize(std::min(parts.size(), kFastest));
        std::vector<Rated> longer;
        for (const Rated& one : combinations)
          for (const auto& [seconds, trial] : parts) {
            longer.push_back({one.choice, one.seconds + seconds});
            longer.back().choice.trials.push_back(trial);
          }
        combinations = std::move(longer);
      }
      for (Rated& one : combinations)
        if (!stores_raw(trials_, one.choice)) all.push_back(std::move(one));
    }
    std::ranges::stable_sort(all, {}, &Rated::seconds);
    std::vector<Choice> choices;
    for (std::size_t i = 0; i < std::min(all.size(), most); ++i) choices.push_back(all[i].choice);
    return choices;
  }

 private:
  const Trials& trials_;
  std::vector<Rated> rated_;
  /// [block size][attribute] seconds and trial
  std::map<std::uint64_t, std::vector<std::vector<std::pair<double, std::size_t>>>> parts_;
};

}  // namespace

double Exhaustive::pick_behind_best() const {
  return finalists.front().seconds / finalists[best].seconds - 1;
}

double Exhaustive::error_of_prediction() const {
  return finalists.front().seconds / finalists.front().predicted - 1;
}

Exhaustive try_all(const Store& store, const Findings& findings, const Advice& advice,
                   const BackendRegistry& backends, const ExhaustiveOptions& options) {
  const Stopwatch clock;
  const Trials& trials = findings.trials;
  const std::uint64_t budget = store.options().budget_bytes;
  const std::uint64_t raw_bytes =
      coarse_levels(store, std::numeric_limits<std::uint64_t>::max()).bytes;
  const std::uint64_t needed = raw_bytes * static_cast<std::uint64_t>(options.finalists + 2);
  if (free_disk_bytes(options.directory) < needed)
    throw Error(
        ErrorCode::kNoSpace,
        fmt::format("tune: --exhaustive under {}: expected {} free bytes, found {}",
                    options.directory.native(), needed, free_disk_bytes(options.directory)));
  const ScratchDirectory scratch(options.directory, "plait-tune");
  Exhaustive tried;
  std::vector<Choice> all;
  for (const std::uint64_t block_bytes : block_sizes(trials))
    for (Choice& choice : covering_choices(trials, block_bytes)) all.push_back(std::move(choice));
  const auto proceed = [&](std::size_t done) {
    const double part = static_cast<double>(done) / static_cast<double>(all.size() + 10);
    if (!options.proceed(part)) throw Error(ErrorCode::kCancelled, "tune: cancelled");
    return true;
  };
  const auto copy = [&](const Choice& choice, const std::filesystem::path& to) {
    copy_store(store, trials, choice, store.finest_level(), to, backends,
               [&](std::uint64_t) { return proceed(tried.stores); });
    ++tried.stores;
  };
  const auto read = [&](const std::filesystem::path& from) {
    const CopyFigures figures = read_cold(from, budget, backends);
    tried.is_cold = tried.is_cold && figures.is_cold;
    return figures.read_seconds;
  };

  Combinations combinations(trials);
  for (const Choice& choice : all) {
    const std::filesystem::path path = scratch.path() / "candidate.plait";
    copy(choice, path);
    std::vector<double> least = read(path);
    for (int again = 1; again < options.reads; ++again) {
      const std::vector<double> seconds = read(path);
      for (std::size_t id = 0; id < least.size(); ++id)
        least[id] = std::min(least[id], seconds[id]);
    }
    std::filesystem::remove_all(path);
    combinations.add(choice, least);
  }

  std::vector<Choice> last = {advice.pick};
  for (Choice& choice : combinations.best(static_cast<std::size_t>(options.finalists) + 1))
    if (choice != advice.pick && last.size() <= static_cast<std::size_t>(options.finalists))
      last.push_back(std::move(choice));
  std::vector<std::vector<double>> seconds(last.size());
  const auto path_of = [&](std::size_t i) { return scratch.path() / fmt::format("{}.plait", i); };
  for (std::size_t i = 0; i < last.size(); ++i) copy(last[i], path_of(i));
  for (int round = 0; round < options.rounds; ++round)
    for (std::size_t i = 0; i < last.size(); ++i) {
      proceed(tried.stores);
      seconds[i].push_back(sum_of(read(path_of(i))));
    }
  for (std::size_t i = 0; i < last.size(); ++i) {
    const double predicted = predict(work_of(trials, last[i]), findings.machine()).read;
    tried.finalists.push_back({last[i], instrument::median(seconds[i]), predicted});
    if (tried.finalists[i].seconds < tried.finalists[tried.best].seconds) tried.best = i;
  }
  tried.seconds = clock.seconds();
  return tried;
}

std::string to_text(const Findings& findings, const Exhaustive& tried) {
  std::string text =
      fmt::format("\n{} stores were made and read{} in {:.0f} s; the last ones, in turn:\n",
                  tried.stores, tried.is_cold ? ", cold," : " from memory", tried.seconds);
  for (std::size_t i = 0; i < tried.finalists.size(); ++i) {
    const Finalist& one = tried.finalists[i];
    text += fmt::format("{} full read {:>8.2f} ms, predicted {:>8.2f} ms  {}{}\n",
                        i == tried.best ? "*" : " ", 1e3 * one.seconds, 1e3 * one.predicted,
                        to_text(findings.trials, one.choice), i == 0 ? " [pick]" : "");
  }
  return text + fmt::format(
                    "the pick takes {:+.1f} % of the best one's time more, and {:+.1f} % "
                    "more than predicted\n",
                    100 * tried.pick_behind_best(), 100 * tried.error_of_prediction());
}

nlohmann::ordered_json to_json(const Findings& findings, const Exhaustive& tried) {
  nlohmann::ordered_json finalists = nlohmann::ordered_json::array();
  for (const Finalist& one : tried.finalists)
    finalists.push_back({{"choice", to_text(findings.trials, one.choice)},
                         {"read_seconds", one.seconds},
                         {"predicted_read_seconds", one.predicted}});
  return {{"stores", tried.stores},
          {"seconds", tried.seconds},
          {"cold", tried.is_cold},
          {"finalists", finalists},
          {"best", tried.best},
          {"pick_behind_best", tried.pick_behind_best()},
          {"error_of_prediction", tried.error_of_prediction()}};
}

}  // namespace plait::tune
