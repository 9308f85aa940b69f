// plait tune: finds the pipelines that suit a surface and a disk, and shows why.

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "argument_text.h"
#include "arguments.h"
#include "base/text.h"
#include "command.h"
#include "console.h"
#include "conversion/conversion_job.h"
#include "instrument/environment.h"
#include "interrupt.h"
#include "json_text.h"
#include "measure.h"
#include "plait/extend/store_access.h"
#include "plait/notes.h"
#include "plait/registry.h"
#include "plait/store.h"
#include "plait/subdivision_job.h"
#include "progress.h"
#include "store/new_output.h"
#include "tune/report.h"

namespace plait {
namespace {

struct TuneArguments {
  std::filesystem::path input;
  std::filesystem::path directory;  ///< empty: that of the input
  std::filesystem::path html, out;
  std::string goal = "read";
  double seconds = 60;
  std::uint64_t memory_bytes = StoreOptions().budget_bytes;
  int threads = 1;
  bool normals = false, apply = false, force = false;
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
  ProgressBar progress("refine", ProgressUnit::kVertices);
  SubdivisionResult made = job->run(
      {.progress =
           [&](const Progress& now) { return progress.update(now.done, now.total, now.phase); },
       .warn = report_warning});
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

tune::TuneFindings measure(const TuneArguments& arguments, const CommandContext& context,
                           Store& store) {
  tune::TuneOptions options;
  options.directory = directory_of(arguments);
  options.seconds = arguments.seconds;
  options.goal = tune::goal_from_name(arguments.goal);
  ProgressBar progress("tune", ProgressUnit::kNone);
  options.proceed = [&](std::string_view phase, double done) {
    return progress.update(static_cast<std::uint64_t>(1000 * done), 1000, phase);
  };
  return tune::measure_store(store, context.plugins.pipelines(), options);
}

/// `surface-tuned.plait` in the measured directory, beside `surface.plait`.
std::filesystem::path output_of(const TuneArguments& arguments) {
  if (!arguments.out.empty()) return arguments.out;
  const std::filesystem::path name =
      std::filesystem::absolute(arguments.input / "").lexically_normal().parent_path().filename();
  return directory_of(arguments) / (name.stem().string() + "-tuned" + name.extension().string());
}

void write_page(const TuneArguments& arguments, const std::string& page) {
  make_new_file(
      arguments.html, arguments.force ? Existing::kReplace : Existing::kRefuse, report_warning,
      [&](UnpublishedFile& output) { output.file().write_at(0, std::as_bytes(std::span(page))); });
}

/// Makes the copy as `plait convert` does, and holds it against what the advice named.
nlohmann::ordered_json apply(const TuneArguments& arguments, const CommandContext& context,
                             const tune::Measured& pick) {
  ConversionRequest request;
  request.from = arguments.input;
  request.to = output_of(arguments);
  request.backend = pick.choice.backend;
  request.compression = tune::compression_of(pick.choice);
  request.budget_bytes = arguments.memory_bytes;
  request.existing = arguments.force ? Existing::kReplace : Existing::kRefuse;
  ProgressBar progress("convert", ProgressUnit::kBytes);
  const Stopwatch clock;
  const ConversionResult made = convert(
      request, context.open_backends, context.backends,
      {.progress = [&](const Progress& now) { return progress.update(now.done, now.total); },
       .warn = report_warning});
  const double seconds = clock.seconds();
  progress.clear();
  const auto bytes = static_cast<double>(made.stored_bytes);
  if (!context.json)
    print(fmt::format("{}: {:.0f} bytes, {:+.1f} % of what was named, in {:.2f} s\n",
                      made.store.native(), bytes, 100 * (bytes / pick.stored_bytes() - 1),
                      seconds));
  return {{"store", made.store.string()},
          {"named_bytes", pick.stored_bytes()},
          {"stored_bytes", bytes},
          {"seconds", seconds}};
}

/// What plait remesh notes of its store: how far the scan is (root of the mean square).
constexpr std::string_view kRemeshRms = "remesh-rms";
/// Of that, for a rounding. A coordinate along the normal is off by a third of its square in the
/// mean of squares, so the distance grows by 1 %.
constexpr double kOfRemeshRms = 0.25;

/// The offer of a rounding, if a store of a scan is exact: no pipeline saves as much.
std::optional<std::string> rounding_offer(const Store& store) {
  const Texts& texts = store.notes().texts();
  const auto noted = texts.find(kRemeshRms);
  if (noted == texts.end() || !store.has_attribute("position") ||
      StoreAccess::rounding(store, store.attribute("position")))
    return std::nullopt;
  double rms = 0;
  const char* const end = noted->second.data() + noted->second.size();
  const auto [after, error] = std::from_chars(noted->second.data(), end, rms);
  if (error != std::errc() || after != end || !(rms > 0) || !std::isfinite(rms))
    return std::nullopt;
  return fmt::format(
      "the store is {} from its scan (root mean square): rounding positions by --max-error {:.2g} "
      "would make that 1 % more, and may save more than any choice here",
      noted->second, kOfRemeshRms * rms);
}

int run_tune(const TuneArguments& arguments, const CommandContext& context) {
  OpenOptions open;
  open.budget_bytes = arguments.memory_bytes / 2;
  std::optional<Refined> refined;
  std::optional<Store> opened;
  const bool is_store = std::filesystem::is_directory(arguments.input);
  const Existing existing = arguments.force ? Existing::kReplace : Existing::kRefuse;
  if (!is_store && arguments.apply)
    throw Error(ErrorCode::kInvalidArgument,
                "tune: --apply converts a store, and this is a mesh: use the command that is "
                "printed");
  // What would be refused at the end is refused at once.
  if (!arguments.html.empty()) UnpublishedFile::check(arguments.html, existing);
  if (arguments.apply) UnpublishedStore::check(output_of(arguments), existing);
  if (is_store)
    opened = Store::open(arguments.input, open, context.open_backends);
  else
    refined = refine(arguments, context);
  Store& store = is_store ? *opened : refined->store;
  tune::TuneFindings findings = measure(arguments, context, store);
  findings.input = arguments.input.string();
  if (is_store) {
    findings.command_start = fmt::format("plait convert {} OUT", shell_word(findings.input));
    if (const auto offer = rounding_offer(store)) findings.notes.push_back(*offer);
  } else {
    findings.notes.push_back(refined->note);
    findings.command_start =
        fmt::format("plait subdivide {} OUT --levels {}{}", shell_word(findings.input),
                    refined->level, arguments.normals ? " --normals" : "");
  }
  const tune::Decision decision = tune::decide(findings.choices, findings.goal);
  nlohmann::ordered_json report = tune::to_json(findings, decision);
  // "command" is the advice.
  report["made_by"] = command_text();
  report["date"] = instrument::date_text();
  report["environment"] = instrument::environment(instrument::disk_facts(directory_of(arguments)));
  if (!arguments.html.empty())
    write_page(arguments, tune::to_html(findings, decision,
                                        fmt::format("{} · {} · {}", instrument::date_text(),
                                                    instrument::machine_text(report["environment"]),
                                                    command_text())));
  if (!context.json) print(tune::to_text(findings, decision));
  if (arguments.apply && !findings.is_interrupted)
    report["applied"] = apply(arguments, context, findings.choices[decision.pick]);
  if (context.json) print(json_text(report));
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
  command
      ->add_option("--seconds", arguments->seconds,
                   "No round begins that would end later, 0.1 to 86400")
      ->range(0.1, 86400.0)
      ->capture_default_str();
  command->add_flag("--normals", arguments->normals, "For a mesh: with unit normals");
  add_size_option(*command, "--memory", arguments->memory_bytes, "Budget for blocks in memory");
  add_threads_option(*command, arguments->threads, "For a mesh: threads that refine it");
  command->add_option("--html", arguments->html, "Also write a page with plots, one file");
  command->add_flag("--apply", arguments->apply, "Make a copy of STORE as advised");
  command->add_option("--out", arguments->out, "The store that --apply makes")
      ->default_str("NAME-tuned.plait in the directory of --dir");
  command->add_flag("--force", arguments->force, "Replace the outputs if they exist");
  add_plugin_option(*command, context);
  add_json_option(*command, context);
  command->footer(
      "The command tries all codecs and filters on the coarser levels, then stores STORE in full\n"
      "under --dir, in up to six ways that include the presets, and reads each of them, in\n"
      "rounds. So bytes and seconds in the table are measured, and the copy of --apply has those\n"
      "bytes. STORE is only read, and the copies are removed. Ctrl-C ends the rounds early and\n"
      "reports what there is; the exit status is 130 then.\n"
      "\n"
      "Examples:\n"
      "  plait tune surface.plait\n"
      "  plait tune surface.plait --dir /mnt/archive --goal size --seconds 300 --html tune.html\n"
      "  plait tune bunny.ply --normals --goal balanced --json\n"
      "  plait tune surface.plait --apply --out small.plait");
  command->callback([arguments, &context] {
    context.run = [arguments, &context] { return run_tune(*arguments, context); };
  });
}

}  // namespace plait
