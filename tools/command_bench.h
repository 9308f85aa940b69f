// tools/command_bench.h: the commands of `plait bench`. Each is in command_bench_NAME.cpp.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "command.h"
#include "io/unpublished.h"
#include "runs/findings.h"
#include "runs/plan.h"
#include "runs/read_runs.h"
#include "runs/record.h"
#include "runs/runner.h"

namespace plait {

void add_bench_run_command(CommandLine& bench, CommandContext& context);
void add_bench_floors_command(CommandLine& bench, CommandContext& context);
void add_bench_report_command(CommandLine& bench, CommandContext& context);
void add_bench_compare_command(CommandLine& bench, CommandContext& context);

/// The options of `plait bench --quick`, which is no command of its own but the answer of `bench`.
/// The result runs it.
std::function<int()> add_bench_quick_options(CommandLine& bench, CommandContext& context);

/// "a,b" as two words. Errors: kInvalidArgument for no word.
std::vector<std::string> words_of(const std::string& list);
/// "90", "90s", "10m" or "2h" as seconds. Errors: kInvalidArgument.
double parse_seconds(const std::string& text);
/// --backend and --memory of `run` and of --quick.
void add_bench_subject_options(CommandLine& command, bench::PlanRequest& request);

/// Errors: kNoSpace, if the plan fills a disk.
void refuse_full_disk(const bench::Plan& plan, std::uint64_t limit_bytes);

/// What a plan measured, for the terminal and as JSON.
struct BenchOutcome {
  bench::RunnerResult result;
  bench::RunSet set;
  bench::Findings findings;
  bool any_failed = false;  ///< a run, or all of them by their digests
};

/// Runs the plan and appends to `file`. A signal ends it early, and what there is counts. `name`
/// stands for the records in findings. Errors: kCancelled if a signal came before the first run had
/// ended.
BenchOutcome measure_plan(const bench::Plan& plan, bench::RunnerOptions options,
                          bench::RecordFile& file, const std::string& name,
                          const CommandContext& context);
/// The outcome on standard output. `html` is a page that was written, or empty.
void print_outcome(const bench::Plan& plan, const BenchOutcome& outcome,
                   const bench::RecordFile& file, const std::filesystem::path& html,
                   const CommandContext& context);

/// Writes the page of a report. `command` is what the page says that it was made by. Errors:
/// kInvalidArgument if the name is taken and `existing` is kRefuse; kIo, kNoSpace.
void write_report_page(const std::filesystem::path& path, Existing existing,
                       const bench::RunSet& set, const bench::Findings& findings,
                       const std::string& command);

}  // namespace plait
