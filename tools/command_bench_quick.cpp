// plait bench --quick: compares all backends on some disks in two minutes, without root.

#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <string>
#include <system_error>
#include <vector>

#include "arguments.h"
#include "command.h"
#include "command_bench.h"
#include "console.h"
#include "interrupt.h"
#include "plait/error.h"

namespace plait {
namespace {

/// The levels of --mesh are as fine as this allows.
constexpr int kMostLevels = 6;
constexpr std::uint64_t kMostOfMemory = 3;

struct BenchQuickArguments {
  bench::PlanRequest request;
  std::vector<std::filesystem::path> directories;
  std::filesystem::path out, mesh, html = "report.html";
  double seconds = 110;  ///< a run that has begun ends, and the page is written
  bool force = false;
};

/// The file of the records: that of --out goes on; the one beside the page is new.
std::filesystem::path place_of_records(const BenchQuickArguments& arguments, Existing existing) {
  if (!arguments.out.empty()) return arguments.out;
  std::filesystem::path path = arguments.html;
  path.replace_extension(".jsonl");
  UnpublishedFile::check(path, existing);
  std::error_code failed;
  std::filesystem::remove(path, failed);
  if (failed) throw system_error("replace", path.native(), failed.value());
  return path;
}

int run_quick(const BenchQuickArguments& arguments, const CommandContext& context) {
  const Existing existing = arguments.force ? Existing::kReplace : Existing::kRefuse;
  UnpublishedFile::check(arguments.html, existing);
  bench::PlanRequest request = arguments.request;
  if (!arguments.directories.empty()) request.disks.clear();
  for (const std::filesystem::path& directory : arguments.directories)
    request.disks.push_back({directory});
  if (request.memory.empty()) {
    std::vector<std::filesystem::path> directories;
    for (const bench::DiskPlace& disk : request.disks) directories.push_back(disk.directory);
    request.memory = {bench::quick_memory(bench::measure_speeds(directories), arguments.seconds)};
  }
  if (!arguments.mesh.empty())
    request.mesh = bench::mesh_subject(arguments.mesh, kMostLevels,
                                       kMostOfMemory * request.memory.front(), &request.levels);
  const bench::Plan plan = bench::make_plan(request, context.backends);
  refuse_full_disk(plan, 0);
  bench::RecordFile file(place_of_records(arguments, existing));
  bench::RunnerOptions options;
  options.seconds = arguments.seconds;
  options.stops_in_round = true;
  options.fio = false;  // `plait bench floors` compares with fio
  const BenchOutcome outcome = measure_plan(plan, options, file, file.path().native(), context);
  // After a signal too: what there is was measured.
  write_report_page(arguments.html, existing, outcome.set, outcome.findings, "plait bench --quick");
  print_outcome(plan, outcome, file, arguments.html, context);
  throw_if_interrupted();
  return outcome.any_failed ? kExitFailed : kExitDone;
}

}  // namespace

std::function<int()> add_bench_quick_options(CommandLine& bench, CommandContext& context) {
  const auto arguments = std::make_shared<BenchQuickArguments>();
  arguments->request.memory.clear();  // by the speed of the disks
  arguments->request.sizes = {2};
  arguments->request.backends = {"all", "auto"};
  arguments->request.workloads = {"build", "sweep-read", "patch-random"};
  bench.add_option("DIR", arguments->directories,
                   "With --quick: directories on the disks; default: the working one");
  add_bench_subject_options(bench, arguments->request);
  bench
      .add_option("--mesh", arguments->mesh,
                  "A surface of your own: a base mesh (PLY, OBJ, OFF), refined until its levels\n"
                  "have three times the memory, six times at most")
      ->type_name("FILE");
  bench.add_parsed_option(
      "--time", [arguments](const std::string& text) { arguments->seconds = parse_seconds(text); },
      "After this no run begins; default 110s");
  bench.add_option("--out", arguments->out,
                   "Append the records to this file, or continue it; default: a new file beside\n"
                   "the page, named as the page with .jsonl");
  bench.add_option("--html", arguments->html, "The page")->capture_default_str();
  bench.add_flag("--force", arguments->force, "Replace the page, and the records beside it");
  add_plugin_option(bench, context);
  add_json_option(bench, context);
  return [arguments, &context] { return run_quick(*arguments, context); };
}

}  // namespace plait
