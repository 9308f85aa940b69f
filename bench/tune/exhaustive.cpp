// plait_bench_tune: holds the advice of `plait tune` against an exhaustive run. It stores a surface
// in full with every candidate, reads all of them, and then measures the choices of `plait tune`
// and the best combinations once more, in the same rounds, and at last the pick beside the best of
// all. Prints a row of a table.
// bench/tune/check.sh runs it for surfaces and disks.

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <limits>
#include <string>

#include "base/stopwatch.h"
#include "instrument/figure_text.h"
#include "instrument/scratch_directory.h"
#include "micro/command_line.h"
#include "plait/registry.h"
#include "tune/report.h"

namespace {

using namespace plait;
using namespace plait::tune;

struct Arguments {
  std::filesystem::path store, directory = ".";
  double seconds = 60;
};

/// The fastest pipeline of each attribute, the second ones, the third ones.
std::vector<Choice> fastest(const Sample& sample) {
  constexpr std::size_t kMost = 3;
  std::vector<Choice> choices;
  for (std::size_t place = 0; place < kMost; ++place) {
    std::vector<std::string> names;
    std::vector<Pipeline> pipelines;
    for (std::size_t at = 0; at < sample.attributes.size(); ++at) {
      std::vector<SampledPipeline> sorted = sample.pipelines[at];
      std::ranges::stable_sort(sorted, {},
                               [](const SampledPipeline& one) { return one.part.read_seconds; });
      names.push_back(sample.attributes[at].name);
      pipelines.push_back(sorted[std::min(place, sorted.size() - 1)].pipeline);
    }
    choices.push_back(choice_of_pipelines(names, pipelines));
  }
  return choices;
}

int run(const Arguments& arguments) {
  Store store = Store::open(arguments.store, {}, default_backends());
  const auto always = [] { return true; };
  TuneOptions options;
  options.directory = arguments.directory;
  options.seconds = arguments.seconds;
  options.proceed = [](std::string_view, double) { return true; };
  const TuneFindings findings = measure_store(store, default_pipelines(), options);
  const Choice pick = findings.choices[decide(findings.choices, Goal::kRead).pick].choice;

  const instrument::ScratchDirectory scratch(arguments.directory);
  const Sample all = take_sample(store, std::numeric_limits<std::uint64_t>::max(), scratch.path(),
                                 Reads::kCold, default_pipelines(), always);
  std::vector<Measured> finalists = {{pick}};
  const auto add = [&](const Choice& choice) {
    if (std::ranges::none_of(finalists, [&](const Measured& one) {
          return store_alike(one.choice, choice, all.attributes);
        }))
      finalists.push_back({choice});
  };
  for (const Measured& one : findings.choices) add(one.choice);
  for (const Choice& choice : fastest(all)) add(choice);
  for (const std::uint64_t block_bytes : {std::uint64_t{64} << 10, std::uint64_t{256} << 10})
    for (Choice choice : {pick, fastest(all).front()}) {
      choice.block_bytes = block_bytes;
      choice.name += fmt::format(", {} KiB", block_bytes >> 10);
      add(choice);
    }
  const auto store_once = [&](const Choice& choice) {
    return store_and_read(store, choice, scratch.path() / "final.plait", Reads::kCold,
                          default_backends(), always);
  };
  const Stopwatch clock;
  measure_rounds(
      finalists, Goal::kRead, 2 * arguments.seconds, [&] { return clock.seconds(); }, store_once);
  std::size_t best = 0;
  for (std::size_t at = 1; at < finalists.size(); ++at)
    if (!finalists[at].runs.empty() && estimate(finalists[at], &CopyRun::read_seconds).value <
                                           estimate(finalists[best], &CopyRun::read_seconds).value)
      best = at;
  // The best of a dozen is partly the luckiest, so it meets the pick once more in rounds of their
  // own.
  std::vector<Measured> duel = {{finalists[0].choice}, {finalists[best].choice}};
  if (best == 0) {
    duel = {finalists[0], finalists[0]};
  } else {
    const Stopwatch clock_of_duel;
    measure_rounds(
        duel, Goal::kRead, arguments.seconds, [&] { return clock_of_duel.seconds(); }, store_once);
  }
  const auto seconds = [&](std::size_t at) {
    return estimate(duel[at], &CopyRun::read_seconds).value;
  };
  const double behind = seconds(0) / seconds(1) - 1;
  fmt::print("| {} | {} | {:.2f} | {} | {} | {:.2f} | {} | {:.1f} % |\n",
             arguments.store.stem().string(), pick.name, duel[0].stored_bytes() / 1048576,
             instrument::seconds_text(seconds(0)), duel[1].choice.name,
             duel[1].stored_bytes() / 1048576, instrument::seconds_text(seconds(1)), 100 * behind);
  return behind <= 0.05 ? 0 : 1;
}

}  // namespace

int main(int count, char** words) {
  Arguments arguments;
  bench::Program program("plait_bench_tune", "Holds plait tune against an exhaustive run");
  CommandLine& options = program.options();
  options.add_option("STORE", arguments.store, "A store")->required();
  options.add_option("--dir", arguments.directory, "On the disk to measure")->capture_default_str();
  options.add_option("--seconds", arguments.seconds, "For plait tune; twice as long for the rest")
      ->range(0.1, 86400.0)
      ->capture_default_str();
  return program.run(count, words, [&] { return run(arguments); });
}
