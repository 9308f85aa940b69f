// What `plait bench run` and --quick measured: on standard output, and as a page.

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "command_bench.h"
#include "console.h"
#include "interrupt.h"
#include "json_text.h"
#include "plait/error.h"
#include "runs/report_page.h"
#include "store/new_output.h"

namespace plait {

void refuse_full_disk(const bench::Plan& plan, std::uint64_t limit_bytes) {
  const std::vector<std::string> lines = bench::refusals(plan, limit_bytes);
  if (!lines.empty()) throw Error(ErrorCode::kNoSpace, lines.front());
}

BenchOutcome measure_plan(const bench::Plan& plan, bench::RunnerOptions options,
                          bench::RecordFile& file, const std::string& name,
                          const CommandContext& context) {
  const bool terminal = ::isatty(STDERR_FILENO) == 1;
  options.proceed = [terminal](const std::string& line) {
    if (terminal && !line.empty()) std::fputs(fmt::format("\r\x1b[K{}", line).c_str(), stderr);
    return !interrupted();
  };
  BenchOutcome outcome;
  outcome.result = bench::run_cells(plan, options, context.backends, file);
  if (terminal) std::fputs("\r\x1b[K", stderr);
  if (file.records().empty()) throw_if_interrupted();
  outcome.set = bench::runs_of(file.records(), name);
  if (outcome.set.runs.empty())
    throw Error(ErrorCode::kBadState, "measure: the time was up before the first run");
  outcome.findings = bench::find(outcome.set);
  outcome.any_failed = outcome.findings.failed;
  for (const bench::MeasuredRun& run : outcome.set.runs)
    outcome.any_failed = outcome.any_failed || !run.ok;
  return outcome;
}

void print_outcome(const bench::Plan& plan, const BenchOutcome& outcome,
                   const bench::RecordFile& file, const std::filesystem::path& html,
                   const CommandContext& context) {
  if (context.json) {
    nlohmann::ordered_json report = bench::to_json(outcome.set, outcome.findings);
    report["rounds"] = outcome.result.rounds;
    report["finished"] = outcome.result.finished;
    report["auto"] = plan.chosen;
    report["left_out"] = plan.left_out;
    report["html"] = html.empty() ? nullptr : nlohmann::ordered_json(html.native());
    report["records"] = file.records();
    return print(json_text(report));
  }
  print(bench::to_text(outcome.set, outcome.findings));
  for (const std::string& line : plan.chosen) print(line + "\n");
  for (const std::string& line : plan.left_out) print(fmt::format("left out: {}\n", line));
  if (!html.empty()) print(fmt::format("{}: the page\n", html.native()));
}

void write_report_page(const std::filesystem::path& path, Existing existing,
                       const bench::RunSet& set, const bench::Findings& findings,
                       const std::string& command) {
  make_new_file(path, existing, report_warning, [&](UnpublishedFile& page) {
    const std::string text = bench::to_page(set, findings, command);
    page.file().write_at(0, std::as_bytes(std::span(text)));
  });
}

}  // namespace plait
