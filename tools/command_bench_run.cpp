// plait bench run: measures cells, round by round.

#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "argument_text.h"
#include "arguments.h"
#include "base/text.h"
#include "command.h"
#include "command_bench.h"
#include "console.h"
#include "interrupt.h"
#include "json_text.h"
#include "plait/error.h"

namespace plait {
namespace {

using bench::PlanRequest;

struct BenchRunArguments {
  PlanRequest request;
  bench::RunnerOptions runner;
  std::vector<std::string> disks;
  std::filesystem::path mesh, out;
  std::uint64_t limit_bytes = 0;
  bool dry_run = false, no_fio = false;
};

/// "NAME=DIR" or "DIR". A directory that has the whole text as its name is meant.
bench::DiskPlace disk_place(const std::string& text) {
  const std::size_t equals = text.find('=');
  std::error_code failed;
  if (equals == std::string::npos || equals == 0 || text.find('/') < equals ||
      std::filesystem::exists(text, failed))
    return {text};
  return {text.substr(equals + 1), text.substr(0, equals)};
}

void print_bench_plan(const bench::Plan& plan, std::uint64_t limit_bytes, bool json) {
  if (!json) {
    std::string text = bench::to_text(plan);
    for (const std::string& line : bench::refusals(plan, limit_bytes))
      text += "refused: " + line + "\n";
    return print(text);
  }
  nlohmann::ordered_json cells = nlohmann::ordered_json::array();
  std::uint64_t bytes = 0;
  for (const bench::Cell& cell : plan.cells) cells.push_back(bench::to_json(cell));
  for (const bench::PlannedDisk& disk : plan.disks) bytes += disk.needed_bytes;
  print(json_text(nlohmann::ordered_json{{"cells", cells},
                                         {"needed_bytes", bytes},
                                         {"minutes", plan.minutes},
                                         {"auto", plan.chosen},
                                         {"left_out", plan.left_out},
                                         {"refused", bench::refusals(plan, limit_bytes)}}));
}

int run_cells(const BenchRunArguments& arguments, const CommandContext& context) {
  PlanRequest request = arguments.request;
  if (!arguments.disks.empty()) request.disks.clear();
  for (const std::string& disk : arguments.disks) request.disks.push_back(disk_place(disk));
  if (arguments.runner.rounds > 0) request.rounds = arguments.runner.rounds;
  if (!arguments.mesh.empty()) request.mesh = bench::mesh_subject(arguments.mesh, request.levels);
  const bench::Plan plan = bench::make_plan(request, context.backends);
  if (arguments.dry_run) {
    print_bench_plan(plan, arguments.limit_bytes, context.json);
    return kExitDone;
  }
  refuse_full_disk(plan, arguments.limit_bytes);
  bench::RunnerOptions options = arguments.runner;
  options.fio = !arguments.no_fio;
  bench::RecordFile file(arguments.out);
  const std::string name = arguments.out.empty() ? "plait bench run" : arguments.out.native();
  const BenchOutcome outcome = measure_plan(plan, options, file, name, context);
  print_outcome(plan, outcome, file, {}, context);
  throw_if_interrupted();
  return outcome.any_failed ? kExitFailed : kExitDone;
}

void add_lists(CommandLine& command, PlanRequest& request) {
  command.add_parsed_option(
      "--workload", [&](const std::string& text) { request.workloads = words_of(text); },
      "Workloads with commas, or all (default); see plait bench list");
  command.add_parsed_option(
      "--block",
      [&](const std::string& text) {
        request.blocks.clear();
        for (const std::string& word : words_of(text)) request.blocks.push_back(parse_size(word));
        for (const std::uint64_t bytes : request.blocks)
          if (bytes < 4096 || bytes > (1u << 30) || (bytes & (bytes - 1)) != 0)
            throw Error(ErrorCode::kInvalidArgument, "expected powers of two from 4KiB to 1GiB");
      },
      "Block sizes with commas; default 64KiB, 256KiB with a backend that compresses, less where "
      "the budget has no room for 16");
  command.add_parsed_option(
      "--threads",
      [&](const std::string& text) {
        request.threads.clear();
        for (const std::string& word : words_of(text))
          request.threads.push_back(static_cast<int>(parse_whole_number(word, 1, 1024)));
      },
      "Numbers of threads with commas; default 1");
}

void add_rounds(CommandLine& command, const std::shared_ptr<BenchRunArguments>& arguments) {
  command.add_parsed_option(
      "--rounds",
      [arguments](const std::string& text) {
        arguments->runner.rounds =
            text == "auto" ? 0 : static_cast<int>(parse_whole_number(text, 1, 200));
      },
      "auto (default): four, then more of what is not decided until the time is up; or N");
  command.add_parsed_option(
      "--time",
      [arguments](const std::string& text) { arguments->runner.seconds = parse_seconds(text); },
      "After this no round begins beyond the fourth: 90s, 10m (default), 2h");
  add_whole_option(command, "--seed", arguments->runner.seed, 0, 1u << 30,
                   "Order of the cells, and the patches");
}

}  // namespace

std::vector<std::string> words_of(const std::string& list) {
  std::vector<std::string> words;
  for (std::size_t at = 0; at <= list.size();) {
    const std::size_t end = std::min(list.find(',', at), list.size());
    if (end > at) words.push_back(list.substr(at, end - at));
    at = end + 1;
  }
  if (words.empty())
    throw Error(ErrorCode::kInvalidArgument, "expected a list with commas, found nothing");
  return words;
}

double parse_seconds(const std::string& text) {
  double unit = 1;
  std::string number = text;
  if (!text.empty() && std::string("smh").find(text.back()) != std::string::npos) {
    unit = text.back() == 's' ? 1 : text.back() == 'm' ? 60 : 3600;
    number.pop_back();
  }
  return unit * static_cast<double>(parse_whole_number(number, 1, 1'000'000));
}

void add_bench_subject_options(CommandLine& command, PlanRequest& request) {
  command.add_parsed_option(
      "--backend", [&](const std::string& text) { request.backends = words_of(text); },
      "Backends with commas, or all (default: all that keep files); auto: the one that plait\n"
      "would choose, which the output names");
  command.add_parsed_option(
      "--memory",
      [&](const std::string& text) {
        request.memory.clear();
        for (const std::string& word : words_of(text)) request.memory.push_back(parse_size(word));
        for (const std::uint64_t bytes : request.memory)
          if (bytes < (16u << 20))
            throw Error(ErrorCode::kInvalidArgument, "expected at least 16MiB");
      },
      "Memory limits of the measured process, with commas; default " +
          (request.memory.empty()
               ? "64 MiB, 32 or\n16 MiB on slow disks, so that the time is enough"
               : format_bytes(request.memory.front())));
}

void add_bench_run_command(CommandLine& bench, CommandContext& context) {
  const auto arguments = std::make_shared<BenchRunArguments>();
  CommandLine* command = bench.add_subcommand("run", "Measure cells, round by round");
  command
      ->add_option("--dir", arguments->disks,
                   "A directory on a disk, or NAME=DIRECTORY to name the disk; may be repeated")
      ->allow_extra_args(false);
  add_bench_subject_options(*command, arguments->request);
  add_lists(*command, arguments->request);
  Option* const mesh =
      command->add_option("--mesh", arguments->mesh, "A base mesh (PLY, OBJ, OFF) to refine");
  add_whole_option(*command, "--vertices", arguments->request.vertices, 64, 100'000'000,
                   "Vertices of a torus as base mesh; default: levels of half and three times the\n"
                   "memory")
      ->excludes(mesh);
  add_whole_option(*command, "--levels", arguments->request.levels, 1, 8,
                   "Levels of the stores; default 4");
  add_rounds(*command, arguments);
  add_size_option(*command, "--limit", arguments->limit_bytes,
                  "Refuse to put more on a disk; a tenth of it stays free in any case");
  command->add_option("--out", arguments->out,
                      "Append records to this file, or continue it; default: keep none");
  command->add_flag("--no-fio", arguments->no_fio, "Measure floors by our own program only");
  command->add_flag("--dry-run", arguments->dry_run,
                    "Only print the cells, bytes, space and minutes");
  add_plugin_option(*command, context);
  add_json_option(*command, context);
  command->footer(
      "Each run is a process under the memory limit. Floors are measured in the same round. A\n"
      "figure that the page cache may have served is labelled warm and has no ratio to a cold\n"
      "floor. At the end the findings are printed, as plait bench report prints them. After\n"
      "Ctrl-C they are those of the runs that there are, and the same command continues the\n"
      "--out file. Exit status 1 if a run failed or backends gave different data.\n"
      "\n"
      "Examples:\n"
      "  plait bench run --dir /mnt/nvme --backend pread,uring --memory 256MiB --out runs.jsonl\n"
      "  plait bench run --dir share=/mnt/nfs --mesh scan.ply --levels 5 --workload build");
  command->callback([arguments, &context] {
    context.run = [arguments, &context] { return run_cells(*arguments, context); };
  });
}

}  // namespace plait
