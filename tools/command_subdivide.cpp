// plait subdivide: refines a mesh and makes a store of it.

#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "arguments.h"
#include "command.h"
#include "compress_arguments.h"
#include "console.h"
#include "interrupt.h"
#include "json_text.h"
#include "made_blocks.h"
#include "measure.h"
#include "plait/error.h"
#include "plait/extend/edge_index.h"
#include "plait/subdivision_job.h"
#include "progress.h"
#include "subdivision_report.h"

namespace plait {
namespace {

/// Options that the command line does not give stay empty.
struct SubdivideArguments {
  std::filesystem::path mesh;
  std::optional<std::string> backend, layout, scheme;
  std::string executor = "auto";
  std::vector<std::string> compress, max_errors;
  bool force = false, resume = false;
  SubdivisionRequest request;  ///< request_of() adds the members above
};

SubdivisionRequest request_of(const SubdivideArguments& arguments,
                              const BackendRegistry& backends) {
  SubdivisionRequest request = arguments.request;
  request.mesh = arguments.mesh;
  request.backend = arguments.backend;
  for (const std::string& text : arguments.max_errors) request.max_errors.add(text);
  const bool rounds = !request.max_errors.empty(), chooses = !arguments.compress.empty();
  const bool compresses = request.backend ? *request.backend != kAutomaticBackend &&
                                                backends.find(*request.backend).traits.compressed
                                          : rounds;
  if (chooses || (rounds && compresses)) request.pipeline_of = pipelines_of(arguments.compress);
  if (arguments.layout) request.layout = layout_from_name(*arguments.layout);
  if (arguments.scheme) request.scheme = scheme_from_name(*arguments.scheme);
  request.executor = executor_from_name(arguments.executor);
  if (arguments.force) request.existing = ExistingStore::kReplace;
  if (arguments.resume) request.existing = ExistingStore::kResume;
  return request;
}

/// Names the command line option that avoids an error of the job.
std::string advice(const Error& error, const SubdivisionPlan& plan) {
  if (error.code() == ErrorCode::kCancelled && plan.commits_levels)
    return "; --resume continues from the last commit";
  if (plan.refusals.empty()) return {};
  switch (plan.refusals.front().field) {
    case SubdivisionField::kBackend:
      return plan.commits_levels ? " (--backend)" : "; add --backend compressed";
    case SubdivisionField::kBlockBytes:
      return " (--block)";
    case SubdivisionField::kExecutor:
      return " (--executor)";
    case SubdivisionField::kExisting:
      return "; --force replaces a store";
    case SubdivisionField::kSize:
      return "; --ignore-size starts anyway";
    case SubdivisionField::kLayout:
      return " (--layout)";
    case SubdivisionField::kLevels:
      return " (--levels)";
    case SubdivisionField::kMaxErrors:
    case SubdivisionField::kVerify:
      return " (--max-error)";
    case SubdivisionField::kLimit:
      return " (--limit)";
    case SubdivisionField::kMaxSlotBytes:
      return " (--max-slot)";
    case SubdivisionField::kNormals:
      return " (--normals)";
    case SubdivisionField::kPipelines:
      return " (--compress)";
    case SubdivisionField::kPrecision:
      return " (--precision)";
    case SubdivisionField::kScheme:
      return " (--scheme)";
    case SubdivisionField::kMesh:
    case SubdivisionField::kStore:
      return {};
  }
  return {};
}

/// Draws a progress bar for each step, and lets a signal cancel the job.
class Watcher {
 public:
  explicit Watcher(bool json) : nothing_is_made_yet_(json) {}

  /// REQUIRES: this object outlives the run of the job.
  SubdivisionWatch watch() {
    return {
        [this](SubdivisionStep step) { enter(step); },
        [this](const Progress& now) { return progress_->update(now.done, now.total, now.phase); },
        [this](const std::string& warning) {
          if (progress_) progress_->clear();
          report_warning(warning);
        }};
  }

 private:
  void enter(SubdivisionStep step) {
    if (step >= SubdivisionStep::kLevels) nothing_is_made_yet_.end();
    const bool levels = step == SubdivisionStep::kLevels;
    const bool bytes = step == SubdivisionStep::kEncode;
    progress_.emplace(levels ? "subdivide" : std::string(to_string(step)),
                      levels  ? ProgressUnit::kVertices
                      : bytes ? ProgressUnit::kBytes
                              : ProgressUnit::kNone);
  }

  EndAtOnce nothing_is_made_yet_;
  std::optional<ProgressBar> progress_;
};

/// What the finished store makes again when it is read; empty for a store that is only in memory.
std::string made_blocks_of(const std::filesystem::path& path, const BackendRegistry& backends) {
  if (path.empty()) return {};
  const Store store = Store::open(path, {}, backends);
  std::string text;
  for (AttributeId id = 0; id < store.attributes().size(); ++id)
    text += made_blocks_text(store, id);
  return text;
}

int run_subdivide(const SubdivideArguments& arguments, const CommandContext& context) {
  SubdivisionReport report;
  report.mesh = arguments.mesh;
  {
    Watcher watcher(context.json);
    SubdivisionJob job(request_of(arguments, context.backends), context.backends);
    compression_of(arguments.compress)
        .check_levels(job.plan().base_level, arguments.request.levels);
    for (const std::string& warning : job.plan().warnings) report_warning(warning);
    try {
      report.result = job.run(watcher.watch());
    } catch (const Error& error) {
      throw Error(error, error.what() + advice(error, job.plan()));
    }
  }
  report.peak_rss_bytes = peak_rss_bytes();
  report.cpu_seconds = cpu_seconds();
  report.seconds = seconds_since_start();
  if (context.json)
    print(json_text(to_json(report)));
  else  // the digest, if there is one, is the last line
    print(made_blocks_of(report.result.store, context.backends) + to_text(report));
  return kExitDone;
}

void add_surface_options(CommandLine& command, SubdivideArguments& arguments) {
  add_whole_option(command, "--levels", arguments.request.levels, 1, kMaxLevel,
                   fmt::format("The level to reach, 1 to {}", kMaxLevel))
      ->required();
  command.add_option("--scheme", arguments.scheme,
                     fmt::format("{}; default {}", scheme_names(), to_string(Scheme())));
  add_precision_option(command, arguments.request.precision,
                       "Type of the positions: float32, float64 or auto: float32, unless it moves "
                       "a vertex of MESH by more than a thousandth of the shortest edge there");
  add_weld_option(command, arguments.request.weld);
  command.add_flag("--normals", arguments.request.normals, "Also compute unit normals");
  command.add_flag(
      "--limit", arguments.request.limit,
      fmt::format("Project positions to the limit surface ({})", limit_scheme_names()));
}

void add_storage_options(CommandLine& command, SubdivideArguments& arguments) {
  command.add_option("--backend", arguments.backend,
                     "The backend that stores the levels (see below); default auto");
  add_compress_option(command, arguments.compress);
  add_max_error_option(command, arguments.max_errors);
  command.add_option(
      "--layout", arguments.layout,
      "Order of edges on disk: auto (chosen by the executor; default), given, spatial, hilbert or "
      "rcm");
  add_size_option(command, "--block", arguments.request.block_bytes,
                  "Unit of I/O, a power of two; default 1MiB");
  add_size_option(command, "--max-slot", arguments.request.max_slot_bytes,
                  "Largest slot of positions: refine the base mesh in memory until all slots fit; "
                  "default 16KiB");
  command
      .add_parsed_option(
          "--durability",
          [&](const std::string& name) {
            arguments.request.durability =
                name == "commit" ? Durability::kCommit : Durability::kNone;
          },
          "commit: wait until the store is on the disk; none: do not wait (temporary stores)")
      ->one_of({"commit", "none"})
      ->default_str("commit");
}

void add_run_options(CommandLine& command, SubdivideArguments& arguments) {
  add_size_option(command, "--memory", arguments.request.budget_bytes,
                  "Budget for blocks in memory");
  add_threads_option(command, arguments.request.threads, "Threads that compute");
  command
      .add_option("--executor", arguments.executor,
                  "auto (fused; with --resume sweep), fused, sweep or transparent")
      ->capture_default_str();
  command.add_flag("--verify", arguments.request.verify,
                   "With --max-error: read the rounded levels back and compare every record with "
                   "the exact one, before the exact levels go");
  command.add_flag("--digest", arguments.request.digest,
                   "Also read all levels at the end and print their digest, as plait digest does");
  command.add_flag("--ignore-size", arguments.request.ignore_size,
                   "Start even if memory, disk or budget are too small for the last level");
  Option* const force = command.add_flag(
      "--force", arguments.force, "Replace STORE if it is a store, when the new store is complete");
  command
      .add_flag("--resume", arguments.resume,
                "Make STORE under its final name and commit every level; if STORE exists, continue "
                "from its last commit (after an interruption, or to reach a finer level)")
      ->excludes(force);
}

}  // namespace

void add_subdivide_command(CommandLine& program, CommandContext& context) {
  const auto arguments = std::make_shared<SubdivideArguments>();
  arguments->request.threads = default_thread_count();
  CommandLine* command = program.add_subcommand("subdivide", "Refine a mesh into a store");
  command->add_option("MESH", arguments->mesh, "PLY, OBJ, OFF or STL, also .gz and .zst")
      ->required();
  add_output_option(*command, "STORE", arguments->request.store,
                    "The store to make, a directory; may be omitted with --backend memory");
  add_surface_options(*command, *arguments);
  add_storage_options(*command, *arguments);
  add_run_options(*command, *arguments);
  add_plugin_option(*command, context);
  add_json_option(*command, context);
  command->footer(
      backend_help(context.backends) + compression_help() +
      "  auto         uring for a store that is large compared with the available memory, if the\n"
      "               kernel and the file system support it; otherwise pread. The files are the\n"
      "               same.\n"
      "\n" +
      max_error_help() +
      " Until the\n"
      "levels are complete, exact and rounded ones take disk space. --max-error implies\n"
      "--compress default.\n"
      "\n"
      "--resume takes scheme, precision, backend, pipelines, layout, block size and base mesh\n"
      "from the store, and refuses options that differ. Normals fit only the level that they were\n"
      "computed for. So a store with normals needs --normals again, and gets the new levels and\n"
      "new normals in one commit.\n"
      "Before it starts, the command compares the memory and the disk space that it needs with "
      "the\n"
      "budget, the available memory and the free disk space, and refuses to start if one of them "
      "is\n"
      "too small (--ignore-size starts anyway).\n"
      "`seconds` is the whole time from the start of the program to its end.\n"
      "\n"
      "Examples:\n"
      "  plait subdivide molecule.ply molecule.plait --levels 5 --normals\n"
      "  plait subdivide bunny.ply bunny.plait --levels 4 --compress fast --memory 64MiB\n"
      "  plait subdivide bunny.ply lossy.plait --levels 6 --max-error 1e-6rel --verify\n"
      "  plait subdivide bunny.ply mixed.plait --levels 6 --compress small --compress @6=fast\n"
      "  plait subdivide spot.ply --levels 3 --backend memory --digest --json\n"
      "  plait subdivide statue.ply statue.plait --levels 6 --resume    again after a "
      "crash\n"
      "  plait subdivide statue.ply statue.plait --levels 7 --resume    one level more");
  command->callback([arguments, &context] {
    context.run = [arguments, &context] { return run_subdivide(*arguments, context); };
  });
}

}  // namespace plait
