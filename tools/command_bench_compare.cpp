// plait bench compare: whether one set of runs is slower than another.

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "arguments.h"
#include "command_bench.h"
#include "console.h"
#include "json_text.h"
#include "plait/error.h"
#include "runs/comparison.h"

namespace plait {
namespace {

struct BenchCompareArguments {
  std::filesystem::path before, after;
  double threshold = 0.05;
};

/// "5%" or "0.05".
double parse_threshold(std::string text) {
  const bool percent = text.ends_with('%');
  if (percent) text.pop_back();
  std::size_t end = 0;
  double value = -1;
  try {
    value = std::stod(text, &end);
  } catch (const std::exception&) {
    end = 0;
  }
  if (percent) value /= 100;
  if (end == 0 || end != text.size() || !(value >= 0 && value <= 100))
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("expected a share such as 5% or 0.05, found \"{}\"", text));
  return value;
}

int run_compare(const BenchCompareArguments& arguments, const CommandContext& context) {
  const bench::RunSet before = bench::read_runs({arguments.before});
  const bench::RunSet after = bench::read_runs({arguments.after});
  const bench::SetComparison comparison = bench::compare(before, after, arguments.threshold);
  if (context.json)
    print(json_text(bench::to_json(comparison)));
  else
    print(bench::to_text(comparison));
  return comparison.passes() ? kExitDone : kExitFailed;
}

}  // namespace

void add_bench_compare_command(CommandLine& bench, CommandContext& context) {
  const auto arguments = std::make_shared<BenchCompareArguments>();
  CommandLine* command = bench.add_subcommand("compare", "Say whether B is slower than A");
  command->add_option("A", arguments->before, "Records of `plait bench run` from before")
      ->required();
  command->add_option("B", arguments->after, "Records of the same cells from after")->required();
  command
      ->add_parsed_option(
          "--threshold",
          [arguments](const std::string& text) { arguments->threshold = parse_threshold(text); },
          "How much slower is a regression, such as 5% or 0.05")
      ->type_name("SHARE")
      ->default_str("5%");
  add_json_option(*command, context);
  command->footer(
      "Compares cell by cell and in strata (all cells, each backend, workload and disk): ratios "
      "to\n"
      "the floor where both have them, else seconds. A difference counts if it is shown among all\n"
      "of these; factors stand with intervals that say the same.\n"
      "\"No difference shown\" is an answer: more rounds may show one.\n"
      "\n"
      "Exit status: 1 for a regression over the threshold, for digests that differ, and for a "
      "cell\n"
      "that fails in B and not in A.\n"
      "\n"
      "Examples:\n"
      "  plait bench compare main.jsonl branch.jsonl\n"
      "  plait bench compare main.jsonl branch.jsonl --threshold 10% --json");
  command->callback([arguments, &context] {
    context.run = [arguments, &context] { return run_compare(*arguments, context); };
  });
}

}  // namespace plait
