// plait bench report: what records of runs show, as a table and as a page.

#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "argument_text.h"
#include "arguments.h"
#include "command_bench.h"
#include "console.h"
#include "interrupt.h"
#include "io/unpublished.h"
#include "json_text.h"
#include "runs/report_page.h"

namespace plait {
namespace {

struct BenchReportArguments {
  std::vector<std::filesystem::path> runs;
  std::filesystem::path html;
  bool force = false;
};

std::string command_of(const BenchReportArguments& arguments) {
  std::string command = "plait bench report";
  for (const auto& file : arguments.runs) command += fmt::format(" {}", shell_word(file.native()));
  return command + " --html " + shell_word(arguments.html.native());
}

int run_report(const BenchReportArguments& arguments, const CommandContext& context) {
  const Existing existing = arguments.force ? Existing::kReplace : Existing::kRefuse;
  if (!arguments.html.empty()) UnpublishedFile::check(arguments.html, existing);
  const bench::RunSet set = bench::read_runs(arguments.runs);
  const bench::Findings findings = bench::find(set);
  throw_if_interrupted();
  if (!arguments.html.empty()) {
    write_report_page(arguments.html, existing, set, findings, command_of(arguments));
  }
  if (context.json) {
    nlohmann::ordered_json report = bench::to_json(set, findings);
    report["html"] =
        arguments.html.empty() ? nullptr : nlohmann::ordered_json(arguments.html.native());
    print(json_text(report));
  } else {
    print(bench::to_text(set, findings));
    if (!arguments.html.empty()) print(fmt::format("{}: the page\n", arguments.html.native()));
  }
  return findings.failed ? kExitFailed : kExitDone;
}

}  // namespace

void add_bench_report_command(CommandLine& bench, CommandContext& context) {
  const auto arguments = std::make_shared<BenchReportArguments>();
  CommandLine* command = bench.add_subcommand("report", "Show what records of runs say");
  command->add_option("RUNS", arguments->runs, "Files of `plait bench run`, from any machine")
      ->required();
  command->add_option("--html", arguments->html,
                      "Also write a page, which needs nothing but itself");
  command->add_flag("--force", arguments->force, "Replace the page if it exists");
  add_json_option(*command, context);
  command->footer(
      "The ratio is the time of a run over that of its floor: a plain program that moves the same\n"
      "bytes in the same round. Backends are compared in pairs by round; what is not shown to be\n"
      "slower or equal is not decided, and the report says how many more minutes would.\n"
      "\n"
      "Exit status: 1 if runs that did the same work left different data.\n"
      "\n"
      "Examples:\n"
      "  plait bench report runs.jsonl\n"
      "  plait bench report nvme.jsonl nfs.jsonl --html report.html");
  command->callback([arguments, &context] {
    context.run = [arguments, &context] { return run_report(*arguments, context); };
  });
}

}  // namespace plait
