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
std::vector<Choice> fastest(Sample sample) {
  constexpr std::size_t kMost = 3;
  for (auto& pipelines : sample.pipelines)
    std::ranges::stable_sort(pipelines, {},
                             [](const SampledPipeline& one) { return one.part.read_seconds; });
  std::vector<Choice> choices;
  for (std::size_t place = 0; place < kMost; ++place) {
    std::vector<Pipeline> chosen;
    for (const auto& pipelines : sample.pipelines)
      chosen.push_back(pipelines[std::min(place, pipelines.size() - 1)].pipeline);
    choices.push_back(choice_of_pipelines(sample.attributes, chosen));
  }
  return choices;
}

double read_seconds(const Measured& one) {
  return one.runs.empty() ? std::numeric_limits<double>::infinity()
                          : estimate(one, &CopyRun::read_seconds).value;
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
  const auto measure = [&](std::vector<Measured>& choices, double seconds) {
    const Stopwatch clock;
    measure_rounds(
        choices, Goal::kRead, seconds, [&] { return clock.seconds(); },
        [&](const Choice& choice) {
          return store_and_read(store, choice, scratch.path() / "final.plait", Reads::kCold,
                                default_backends(), always);
        });
  };
  measure(finalists, 2 * arguments.seconds);
  const auto best = std::ranges::min_element(finalists, {}, read_seconds);
  // The best of a dozen is partly the luckiest, so it meets the pick once more in rounds of their
  // own.
  std::vector<Measured> duel = {finalists.front(), finalists.front()};
  if (best != finalists.begin()) {
    duel = {{pick}, {best->choice}};
    measure(duel, arguments.seconds);
  }
  const double behind = read_seconds(duel[0]) / read_seconds(duel[1]) - 1;
  fmt::print("| {} | {} | {:.2f} | {} | {} | {:.2f} | {} | {:.1f} % |\n",
             arguments.store.stem().string(), pick.name, duel[0].stored_bytes() / 1048576,
             instrument::seconds_text(read_seconds(duel[0])), duel[1].choice.name,
             duel[1].stored_bytes() / 1048576, instrument::seconds_text(read_seconds(duel[1])),
             100 * behind);
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
