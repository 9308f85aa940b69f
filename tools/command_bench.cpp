// plait bench: measures backends on disks. This file has `plait bench --quick`, `run`, `list` and
// `floors`.

#include <fmt/format.h>
#include <stdlib.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "argument_text.h"
#include "arguments.h"
#include "bench/bench_commands.h"
#include "bench/floor_table.h"
#include "bench/plan.h"
#include "bench/run_table.h"
#include "bench/runner.h"
#include "bench/workloads.h"
#include "command.h"
#include "console.h"
#include "instrument/disk_floors.h"
#include "interrupt.h"
#include "plait/error.h"

namespace plait {
namespace {

using bench::PlanRequest;

struct Arguments {
  PlanRequest request;
  bench::RunnerOptions runner;
  std::vector<std::filesystem::path> directories;
  std::filesystem::path out, html = "report.html";
  std::uint64_t limit_bytes = 0, floor_bytes = 256u << 20, block_bytes = 1u << 20;
  bool dry_run = false, quick = false, no_fio = false, force = false;
};

std::vector<std::string> split(const std::string& text) {
  std::vector<std::string> words;
  for (std::size_t at = 0; at <= text.size();) {
    const std::size_t end = std::min(text.find(',', at), text.size());
    if (end > at) words.push_back(text.substr(at, end - at));
    at = end + 1;
  }
  if (words.empty())
    throw Error(ErrorCode::kInvalidArgument, "expected a list with commas, found nothing");
  return words;
}

/// "90", "90s", "10m" or "2h".
double parse_seconds(const std::string& text) {
  double unit = 1;
  std::string number = text;
  if (!text.empty() && std::string("smh").find(text.back()) != std::string::npos) {
    unit = text.back() == 's' ? 1 : text.back() == 'm' ? 60 : 3600;
    number.pop_back();
  }
  return unit * static_cast<double>(parse_whole_number(number, 1, 1'000'000));
}

void refuse_full_disk(const bench::Plan& plan, std::uint64_t limit_bytes) {
  const std::vector<std::string> lines = bench::refusals(plan, limit_bytes);
  if (!lines.empty()) throw Error(ErrorCode::kNoSpace, lines.front());
}

/// Runs the plan and prints the table. Returns the exit status.
int run_plan(const bench::Plan& plan, bench::RunnerOptions options, bench::RecordFile& file,
             const CommandContext& context) {
  const bool terminal = ::isatty(STDERR_FILENO) == 1;
  options.proceed = [terminal](const std::string& line) {
    if (terminal && !line.empty()) std::fputs(fmt::format("\r\x1b[K{}", line).c_str(), stderr);
    return !interrupted();
  };
  const bench::RunnerResult result = bench::run_cells(plan, options, context.backends, file);
  if (terminal) std::fputs("\r\x1b[K", stderr);
  const std::vector<std::string> different = bench::different_digests(file.records());
  bool failed = !different.empty();
  for (const nlohmann::ordered_json& record : file.records())
    failed = failed || record["outcome"] != "ok";
  if (context.json) {
    print(nlohmann::ordered_json{{"rounds", result.rounds},
                                 {"finished", result.finished},
                                 {"limit_doubt", result.limit_doubt},
                                 {"different_digests", different},
                                 {"verdict", bench::verdict(file.records())},
                                 {"left_out", plan.left_out},
                                 {"records", file.records()}}
              .dump(2) +
          "\n");
  } else {
    // What spoils all figures comes before them.
    for (const std::string& line : different) print(fmt::format("FAILED: {}\n", line));
    if (!result.limit_doubt.empty()) print(fmt::format("doubt: {}\n", result.limit_doubt));
    print(bench::run_table(file.records()));
    for (const std::string& line : plan.left_out) print(fmt::format("left out: {}\n", line));
    print(bench::verdict(file.records()));
  }
  throw_if_interrupted();
  return failed ? kExitFailed : kExitDone;
}

int run_quick(const Arguments& arguments, const CommandContext& context) {
  const Existing existing = arguments.force ? Existing::kReplace : Existing::kRefuse;
  PartialFile::check(arguments.html, existing);
  PlanRequest request;
  if (!arguments.directories.empty()) request.directories = arguments.directories;
  request.memory = {96u << 20};
  request.sizes = {2};
  request.workloads = {"build", "sweep-read", "patch-random"};
  const bench::Plan plan = bench::make_plan(request, context.backends);
  refuse_full_disk(plan, arguments.limit_bytes);
  bench::RunnerOptions options;
  options.seconds = 105;  // a run that has begun ends, and the report is written
  options.stops_in_round = true;
  options.seed = arguments.runner.seed;
  bench::RecordFile file(arguments.out);
  const int status = run_plan(plan, options, file, context);
  const bench::RunSet set = bench::runs_of(file.records(), "plait bench --quick");
  write_report_page(arguments.html, existing, set, bench::find(set), "plait bench --quick");
  if (!context.json) print(fmt::format("{}: the page\n", arguments.html.native()));
  return status;
}

int run_cells(const Arguments& arguments, const CommandContext& context) {
  PlanRequest request = arguments.request;
  if (!arguments.directories.empty()) request.directories = arguments.directories;
  if (arguments.runner.rounds > 0) request.rounds = arguments.runner.rounds;
  const bench::Plan plan = bench::make_plan(request, context.backends);
  if (arguments.dry_run) {
    std::string text = bench::to_text(plan);
    for (const std::string& line : bench::refusals(plan, arguments.limit_bytes))
      text += "refused: " + line + "\n";
    if (context.json) {
      nlohmann::ordered_json cells = nlohmann::ordered_json::array();
      std::uint64_t bytes = 0;
      for (const bench::Cell& cell : plan.cells) cells.push_back(bench::to_json(cell));
      for (const bench::PlannedDisk& disk : plan.disks) bytes += disk.needed_bytes;
      text = nlohmann::ordered_json{{"cells", cells},
                                    {"needed_bytes", bytes},
                                    {"minutes", plan.minutes},
                                    {"left_out", plan.left_out}}
                 .dump(2) +
             "\n";
    }
    print(text);
    return kExitDone;
  }
  refuse_full_disk(plan, arguments.limit_bytes);
  bench::RunnerOptions options = arguments.runner;
  options.fio = !arguments.no_fio;
  bench::RecordFile file(arguments.out);
  return run_plan(plan, options, file, context);
}

int run_list(const CommandContext& context) {
  nlohmann::ordered_json workloads, backends;
  for (const bench::Workload& workload : bench::workloads())
    workloads[std::string(workload.name)] = workload.summary;
  for (const std::string& name : context.backends.names())
    backends[name] = context.backends.find(name).summary;
  if (context.json) {
    print(nlohmann::ordered_json{{"workloads", workloads}, {"backends", backends}}.dump(2) + "\n");
    return kExitDone;
  }
  for (const auto& [title, entries] :
       {std::pair{"Workloads", &workloads}, {"Backends", &backends}}) {
    print(fmt::format("{}:\n", title));
    for (const auto& [name, summary] : entries->items())
      print(fmt::format("  {:<22}{}\n", name, summary.get<std::string>()));
  }
  return kExitDone;
}

int run_floors(const Arguments& arguments, const CommandContext& context) {
  std::vector<std::filesystem::path> directories = arguments.directories;
  if (directories.empty()) directories = {"."};
  std::vector<nlohmann::ordered_json> floors;
  for (const std::filesystem::path& directory : directories) {
    const instrument::DiskFacts facts = instrument::disk_facts(directory);
    if (2 * arguments.floor_bytes > instrument::usable_bytes(facts))
      throw Error(ErrorCode::kNoSpace,
                  fmt::format("measure {}: a tenth of the disk must stay free; give a smaller "
                              "--bytes",
                              directory.native()));
    throw_if_interrupted();
    std::string name = (directory / "plait-bench-XXXXXX").native();
    if (::mkdtemp(name.data()) == nullptr) throw system_error("create", name, errno);
    for (nlohmann::ordered_json& floor : bench::measure_floors(
             name, arguments.floor_bytes, arguments.block_bytes, !arguments.no_fio)) {
      floor["directory"] = directory.native();
      floors.push_back(std::move(floor));
    }
    std::error_code ignored;
    std::filesystem::remove_all(name, ignored);
  }
  print(context.json ? nlohmann::ordered_json{{"floors", floors}}.dump(2) + "\n"
                     : bench::floor_table(floors));
  return kExitDone;
}

void add_list_options(CommandLine& command, PlanRequest& request) {
  command.add_parsed_option(
      "--backend", [&](const std::string& text) { request.backends = split(text); },
      "Backends with commas, or all (default: all that keep files)");
  command
      .add_option("--codec", request.codecs,
                  "A pipeline for backends that compress; may be repeated")
      ->allow_extra_args(false);
  command.add_parsed_option(
      "--workload", [&](const std::string& text) { request.workloads = split(text); },
      "Workloads with commas, or all (default); see plait bench list");
  command.add_parsed_option(
      "--memory",
      [&](const std::string& text) {
        request.memory.clear();
        for (const std::string& word : split(text)) request.memory.push_back(parse_size(word));
        for (const std::uint64_t bytes : request.memory)
          if (bytes < (16u << 20))
            throw Error(ErrorCode::kInvalidArgument, "expected at least 16MiB");
      },
      "Memory limits of the measured process, with commas; default 256MiB");
  command.add_parsed_option(
      "--block",
      [&](const std::string& text) {
        request.blocks.clear();
        for (const std::string& word : split(text)) request.blocks.push_back(parse_size(word));
        for (const std::uint64_t bytes : request.blocks)
          if (bytes < 4096 || bytes > (1u << 30) || (bytes & (bytes - 1)) != 0)
            throw Error(ErrorCode::kInvalidArgument, "expected powers of two from 4KiB to 1GiB");
      },
      "Block sizes with commas; default 1MiB");
  command.add_parsed_option(
      "--threads",
      [&](const std::string& text) {
        request.threads.clear();
        for (const std::string& word : split(text))
          request.threads.push_back(static_cast<int>(parse_whole_number(word, 1, 1024)));
      },
      "Numbers of threads with commas; default 1");
}

void add_run_command(CommandLine& bench, CommandContext& context) {
  const auto arguments = std::make_shared<Arguments>();
  CommandLine* command = bench.add_subcommand("run", "Measure cells, round by round");
  command->add_option("--dir", arguments->directories, "A directory on a disk; may be repeated")
      ->allow_extra_args(false);
  add_list_options(*command, arguments->request);
  add_whole_option(*command, "--vertices", arguments->request.vertices, 64, 100'000'000,
                   "Vertices of the base mesh; default: levels of 0.5, 2 and 4 times the memory");
  add_whole_option(*command, "--levels", arguments->request.levels, 1, 8,
                   "Levels of the stores; default 4");
  command->add_parsed_option(
      "--rounds",
      [arguments](const std::string& text) {
        arguments->runner.rounds =
            text == "auto" ? 0 : static_cast<int>(parse_whole_number(text, 1, 200));
      },
      "auto (default): five, then until the intervals are under 5 % or the time is up; or N");
  command->add_parsed_option(
      "--time",
      [arguments](const std::string& text) { arguments->runner.seconds = parse_seconds(text); },
      "After this no round begins beyond the fifth: 90s, 10m (default), 2h");
  add_size_option(*command, "--limit", arguments->limit_bytes,
                  "Refuse to put more on a disk; a tenth of it stays free in any case");
  command
      ->add_option("--rate", arguments->request.rate,
                   "Requests a second of patch workloads (an open loop); default: closed loop")
      ->range(0.1, 1e6);
  add_whole_option(*command, "--seed", arguments->runner.seed, 0, 1u << 30,
                   "Order of the cells, and the patches");
  command->add_option("--out", arguments->out,
                      "Append records to this file, or continue it; default: keep none");
  command->add_flag("--warm", arguments->runner.warm,
                    "Leave the page cache as it is; every figure is labelled warm");
  command->add_flag("--no-fio", arguments->no_fio, "Measure floors by our own program only");
  command->add_flag("--dry-run", arguments->dry_run,
                    "Only print the cells, bytes, space and minutes");
  add_plugin_option(*command, context);
  add_json_option(*command, context);
  command->footer(
      "Each run is a process under the memory limit. Floors are measured in the same round. A\n"
      "figure that the page cache may have served is labelled warm and has no ratio to a cold\n"
      "floor. The same command continues an interrupted --out file. Exit status 1 if a run failed\n"
      "or backends gave different data.\n"
      "\n"
      "Example:\n"
      "  plait bench run --dir /mnt/nvme --backend pread,uring --memory 256MiB --out runs.jsonl");
  command->callback([arguments, &context] {
    context.run = [arguments, &context] { return run_cells(*arguments, context); };
  });
}

void add_floors_command(CommandLine& bench, CommandContext& context) {
  const auto arguments = std::make_shared<Arguments>();
  CommandLine* command = bench.add_subcommand("floors", "Measure what disks can do without plait");
  command->add_option("DIR", arguments->directories, "Directories; default: the working one");
  add_size_option(*command, "--bytes", arguments->floor_bytes, "To move; default 256MiB");
  add_size_option(*command, "--block", arguments->block_bytes, "Unit of I/O; default 1MiB");
  command->add_flag("--no-fio", arguments->no_fio, "Only by our own program");
  add_json_option(*command, context);
  command->callback([arguments, &context] {
    context.run = [arguments, &context] { return run_floors(*arguments, context); };
  });
}

}  // namespace

void add_bench_command(CommandLine& program, CommandContext& context) {
  const auto arguments = std::make_shared<Arguments>();
  CommandLine* command =
      program.add_subcommand("bench", "Measure backends on disks, with floors and proofs");
  command->add_option("DIR", arguments->directories,
                      "With --quick: directories on the disks; default: the working one");
  command->add_flag("--quick", arguments->quick, "Compare all backends in two minutes");
  command->add_option("--out", arguments->out, "With --quick: append the records to this file");
  command->add_option("--html", arguments->html, "With --quick: the page")->capture_default_str();
  command->add_flag("--force", arguments->force, "With --quick: replace the page if it exists");
  add_run_command(*command, context);
  CommandLine* const list = command->add_subcommand("list", "List the workloads and the backends");
  add_plugin_option(*list, context);
  add_json_option(*list, context);
  list->callback([&context] { context.run = [&context] { return run_list(context); }; });
  add_floors_command(*command, context);
  add_bench_report_command(*command, context);
  add_bench_compare_command(*command, context);
  command->footer(
      "docs/bench-records.md explains the records.\n"
      "\n"
      "Examples:\n"
      "  plait bench --quick /mnt/nvme /mnt/share\n"
      "  plait bench run --dir /mnt/nvme --workload sweep-read,build --out runs.jsonl --dry-run\n"
      "  plait bench report runs.jsonl --html report.html\n"
      "  plait bench compare main.jsonl branch.jsonl");
  command->callback([arguments, &context] {
    if (context.run) return;  // a command of its own
    if (!arguments->quick)
      throw UsageError(
          "no command was given: expected --quick, run, list, floors, report or compare");
    context.run = [arguments, &context] { return run_quick(*arguments, context); };
  });
}

}  // namespace plait
