// plait tune: finds the pipelines that suit a surface and a disk, and shows why.

#include <fmt/format.h>

#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "argument_text.h"
#include "arguments.h"
#include "command.h"
#include "console.h"
#include "interrupt.h"
#include "plait/backends/registry.h"
#include "plait/byte_text.h"
#include "plait/kernels/subdivision_job.h"
#include "plait/partial_output.h"
#include "plait/partial_store.h"
#include "plait/store.h"
#include "progress.h"
#include "tune/apply.h"
#include "tune/exhaustive.h"
#include "tune/page.h"
#include "tune/tune.h"

namespace plait {
namespace {

struct TuneArguments {
  std::filesystem::path input;
  std::filesystem::path directory;  ///< empty: that of the input
  std::filesystem::path html, out;
  std::string goal = "read";
  double seconds = 60;
  std::uint64_t seed = 1, memory_bytes = StoreOptions().budget_bytes;
  int threads = default_thread_count();
  bool normals = false, apply = false, exhaustive = false, force = false;
};

/// The surface of a mesh, in memory, at the finest level that takes at most a half of the memory.
struct Refined {
  Store store;
  std::string note;
  int level = 0;
};

Refined refine(const TuneArguments& arguments, const CommandContext& context) {
  constexpr int kFinest = 6;
  std::optional<SubdivisionJob> job;
  int level = kFinest;
  for (;; --level) {
    SubdivisionRequest request;
    request.mesh = arguments.input;
    request.backend = "memory";
    request.levels = level;
    request.normals = arguments.normals;
    request.threads = arguments.threads;
    request.budget_bytes = arguments.memory_bytes;
    request.ignore_size = true;
    job.emplace(std::move(request), context.backends);
    if (level == 1 || job->plan().size.level_bytes <= arguments.memory_bytes / 2) break;
  }
  for (const std::string& warning : job->plan().warnings) report_warning(warning);
  Progress progress("refine", ProgressUnit::kVertices);
  SubdivisionResult made = job->run({[&](const SubdivisionProgress& now) {
                                       return progress.update(now.done, now.total, now.phase);
                                     },
                                     report_warning});
  return {std::move(*made.in_memory),
          fmt::format("The mesh was refined in memory by Loop's rule to level {}, {}: the figures "
                      "are of that surface, and scanned surfaces compress less",
                      level, format_bytes(made.plan.size.level_bytes)),
          level};
}

std::filesystem::path directory_of(const TuneArguments& arguments) {
  if (!arguments.directory.empty()) return arguments.directory;
  const std::filesystem::path parent =
      std::filesystem::absolute(arguments.input).lexically_normal().parent_path();
  return parent.empty() ? "." : parent;
}

tune::Findings measure(const TuneArguments& arguments, const CommandContext& context,
                       const Store& store) {
  tune::TuneOptions options;
  options.directory = directory_of(arguments);
  options.seconds = arguments.seconds;
  options.seed = arguments.seed;
  options.memory_bytes = arguments.memory_bytes;
  options.threads = arguments.threads;
  options.goal = tune::goal_from_name(arguments.goal);
  Progress progress("tune", ProgressUnit::kNone);
  options.proceed = [&](std::string_view phase, double done) {
    return progress.update(static_cast<std::uint64_t>(1000 * done), 1000, phase);
  };
  return tune::measure_store(store, context.plugins.pipelines(), options);
}

tune::Exhaustive try_all(const TuneArguments& arguments, const CommandContext& context,
                         const Store& store, const tune::Findings& findings,
                         const tune::Advice& advice) {
  Progress progress("try all", ProgressUnit::kNone);
  tune::ExhaustiveOptions options;
  options.directory = directory_of(arguments);
  options.proceed = [&](double done) {
    return progress.update(static_cast<std::uint64_t>(1000 * done), 1000);
  };
  return tune::try_all(store, findings, advice, default_backends(context.plugins.pipelines()),
                       options);
}

/// `surface-tuned.plait` in the measured directory, beside `surface.plait`.
std::filesystem::path output_of(const TuneArguments& arguments) {
  if (!arguments.out.empty()) return arguments.out;
  const std::filesystem::path name =
      std::filesystem::absolute(arguments.input / "").lexically_normal().parent_path().filename();
  return directory_of(arguments) / (name.stem().string() + "-tuned" + name.extension().string());
}

void write_page(const TuneArguments& arguments, const tune::Findings& findings,
                const tune::Advice& advice) {
  PartialFile output(arguments.html, arguments.force ? Existing::kReplace : Existing::kRefuse);
  const std::string page = tune::to_html(findings, advice);
  output.file().write_at(0, std::as_bytes(std::span(page)));
  output.publish();
}

int run_tune(const TuneArguments& arguments, const CommandContext& context) {
  OpenOptions open;
  open.budget_bytes = arguments.memory_bytes / 2;
  std::optional<Refined> refined;
  std::optional<Store> opened;
  const bool is_store = std::filesystem::is_directory(arguments.input);
  if (!is_store && (arguments.apply || arguments.exhaustive))
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("tune: {} converts a store, and this is a mesh: use the command that "
                            "is printed",
                            arguments.apply ? "--apply" : "--exhaustive"));
  // What would be refused at the end is refused at once.
  if (!arguments.html.empty())
    PartialFile::check(arguments.html, arguments.force ? Existing::kReplace : Existing::kRefuse);
  if (arguments.apply)
    PartialStore::check(output_of(arguments),
                        arguments.force ? Existing::kReplace : Existing::kRefuse);
  if (is_store)
    opened = Store::open(arguments.input, open, context.open_backends);
  else
    refined = refine(arguments, context);
  const Store& store = is_store ? *opened : refined->store;
  tune::Findings findings = measure(arguments, context, store);
  findings.input = arguments.input.string();
  if (is_store) {
    findings.command_start = fmt::format("plait convert {} OUT", shell_word(findings.input));
  } else {
    findings.note = refined->note;
    findings.command_start =
        fmt::format("plait subdivide {} OUT --levels {}{}", shell_word(findings.input),
                    refined->level, arguments.normals ? " --normals" : "");
  }
  const tune::Advice advice = tune::advise(findings);
  if (!arguments.html.empty()) write_page(arguments, findings, advice);
  nlohmann::ordered_json report = tune::to_json(findings, advice);
  if (!context.json) print(tune::to_text(findings, advice));
  if (arguments.apply && !findings.is_interrupted) {
    Progress progress("convert", ProgressUnit::kBytes);
    const tune::Applied applied = tune::apply(
        *opened, findings, advice, output_of(arguments), arguments.force, context.backends,
        [&](std::uint64_t done, std::uint64_t total) { return progress.update(done, total); });
    progress.clear();
    if (!context.json) print(tune::to_text(applied));
    report["applied"] = tune::to_json(applied);
  }
  if (arguments.exhaustive && !findings.is_interrupted) {
    const tune::Exhaustive tried = try_all(arguments, context, store, findings, advice);
    if (!context.json) print(tune::to_text(findings, tried));
    report["exhaustive"] = tune::to_json(findings, tried);
  }
  if (context.json) print(report.dump(2) + "\n");
  // What there is was reported; a script still has to know that the run was cut short.
  return findings.is_interrupted ? kExitSignalBase + interrupt_signal() : kExitDone;
}

}  // namespace

void add_tune_command(CommandLine& program, CommandContext& context) {
  const auto arguments = std::make_shared<TuneArguments>();
  CommandLine* command = program.add_subcommand(
      "tune", "Find the compression that suits a surface and a disk, by measuring both");
  command->add_option("STORE", arguments->input, "A store, or a mesh: PLY, OBJ or OFF")->required();
  command->add_option("--dir", arguments->directory, "A directory on the disk to measure")
      ->default_str("where STORE is");
  command
      ->add_option("--goal", arguments->goal,
                   "What shall be small: read, write, update, size or balanced")
      ->one_of({"read", "write", "update", "size", "balanced"})
      ->capture_default_str();
  command->add_option("--seconds", arguments->seconds, "How long to measure, 0.1 to 86400")
      ->range(0.1, 86400.0)
      ->capture_default_str();
  add_whole_option(*command, "--seed", arguments->seed, 0,
                   std::numeric_limits<std::uint64_t>::max(), "Each seed gives another sample")
      ->default_str("1");
  command->add_flag("--normals", arguments->normals, "For a mesh: with unit normals");
  add_size_option(*command, "--memory", arguments->memory_bytes, "Budget for blocks in memory");
  add_threads_option(*command, arguments->threads, "Threads that read and write a store");
  command->add_option("--html", arguments->html, "Also write a page with plots, one file");
  command->add_flag("--apply", arguments->apply,
                    "Make a tuned copy of STORE, and compare it with the prediction");
  command->add_flag("--exhaustive", arguments->exhaustive,
                    "Then store and read STORE with every candidate, and compare the pick");
  command->add_option("--out", arguments->out, "The store that --apply makes")
      ->default_str("NAME-tuned.plait in the directory of --dir");
  command->add_flag("--force", arguments->force, "Replace the outputs if they exist");
  add_plugin_option(*command, context);
  add_json_option(*command, context);
  command->footer(
      "The command writes and reads a temporary file to measure the disk, tries all codecs,\n"
      "filters and sizes of blocks on a sample of the surface, in turn, and stores and reads the\n"
      "likely choices beside that file. STORE is only read. Ctrl-C ends the measurement early\n"
      "and reports what there is; the exit status is 130 then. docs/tune.md has the formulas of\n"
      "the predictions.\n"
      "\n"
      "Examples:\n"
      "  plait tune surface.plait\n"
      "  plait tune surface.plait --dir /mnt/archive --goal size --seconds 300 --html tune.html\n"
      "  plait tune bunny.ply --normals --goal balanced --json\n"
      "  plait tune surface.plait --apply --out small.plait\n"
      "  plait tune surface.plait --exhaustive");
  command->callback([arguments, &context] {
    context.run = [arguments, &context] { return run_tune(*arguments, context); };
  });
}

}  // namespace plait
