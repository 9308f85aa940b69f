// plait subdivide: a mesh in, a store out.

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "arguments.h"
#include "command.h"
#include "console.h"
#include "final_name.h"
#include "interrupt.h"
#include "measure.h"
#include "partial_output.h"
#include "plait/edge_index.h"
#include "plait/kernels/subdivide.h"
#include "plait/layout.h"
#include "plait/mesh_io.h"
#include "plait/store.h"
#include "progress.h"
#include "read_back.h"
#include "resume.h"
#include "subdivide_report.h"

namespace plait {
namespace {

struct Arguments {
  std::filesystem::path mesh, store;
  int levels = 0;
  std::string backend = StoreOptions().backend;
  std::string codec, filter;  ///< empty: not given
  std::string executor = "auto", layout = "auto", scheme = "loop", precision = "float32",
              durability = "commit";
  std::uint64_t memory_bytes = StoreOptions().budget_bytes;
  std::uint64_t block_bytes = StoreOptions().block_bytes;
  std::uint64_t max_slot_bytes = 16 << 10;
  int threads = default_thread_count();
  bool normals = false, limit = false, digest = false, force = false, resume = false;
};

/// Everything that can be refused before the mesh is read.
struct Plan {
  StoreOptions store;
  SubdivideOptions subdivide;
  LayoutKind layout = LayoutKind::kAutomatic;
  bool double_precision = false;
  std::optional<PartialOutput> output;  ///< none: the store is only in memory
};

void make_plan(const Arguments& arguments, const BackendRegistry& backends, Plan& plan) {
  const BackendRegistry::Entry& backend = backends.find(arguments.backend);
  if (!backend.traits.compressed && !(arguments.codec.empty() && arguments.filter.empty()))
    throw Error(ErrorCode::kInvalidArgument,
                "subdivide: --codec and --filter need a backend that compresses, and " +
                    backend.name + " does not");
  plan.store.backend = backend.name;
  if (!arguments.codec.empty()) plan.store.backend_options.codec = arguments.codec;
  if (!arguments.filter.empty()) plan.store.backend_options.filter = arguments.filter;
  backend.validate(plan.store.backend_options);
  plan.store.block_bytes = arguments.block_bytes;
  plan.store.budget_bytes = arguments.memory_bytes;
  plan.store.durability = arguments.durability == "none" ? Durability::kNone : Durability::kCommit;

  plan.layout = layout_from_name(arguments.layout);
  plan.double_precision = arguments.precision == "float64";
  plan.subdivide.scheme = scheme_from_name(arguments.scheme);
  plan.subdivide.executor = arguments.executor != "auto" ? executor_from_name(arguments.executor)
                            : arguments.resume           ? ExecutorKind::kSweep
                                                         : ExecutorKind::kFused;
  // What is under way at once decides here, not how far stencils reach.
  if (plan.layout == LayoutKind::kAutomatic && plan.subdivide.executor == ExecutorKind::kFused)
    plan.layout = LayoutKind::kHilbert;
  plan.subdivide.levels = arguments.levels;
  plan.subdivide.normals = arguments.normals;
  plan.subdivide.limit = arguments.limit;
  plan.subdivide.threads =
      plan.subdivide.executor == ExecutorKind::kTransparent ? 1 : arguments.threads;
  // Limit positions are none that a subdivision could go on from.
  plan.store.scheme =
      std::string(to_string(plan.subdivide.scheme)) + (arguments.limit ? " limit" : "");
  if (arguments.resume && (arguments.limit || !backend.traits.durable ||
                           plan.subdivide.executor == ExecutorKind::kFused))
    throw Error(ErrorCode::kInvalidArgument,
                "subdivide: --resume needs a backend that keeps levels and an executor that makes "
                "one after another (sweep, transparent), and goes without --limit");

  if (!backend.traits.durable) {
    if (!arguments.store.empty())
      report_warning("backend " + backend.name + " keeps nothing: " + arguments.store.native() +
                     " is not made");
    return;
  }
  if (arguments.store.empty())
    throw Error(ErrorCode::kInvalidArgument,
                "subdivide: STORE is missing; only a backend that keeps nothing goes without");
  if (arguments.resume) return;
  plan.output.emplace(arguments.store, arguments.force ? Existing::kReplace : Existing::kRefuse);
}

/// Reads, refines in memory where slots would be too large, and orders the mesh; as `existing` was,
/// if there is one.
LaidOutMesh prepare_mesh(const Arguments& arguments, Plan& plan, const Store* existing, bool json,
                         SubdivideReport& report) {
  const EndAtOnce nothing_is_made_yet(json);
  Stopwatch clock;
  std::vector<std::string> warnings;
  BaseMesh mesh = read_base_mesh(arguments.mesh, &warnings);
  report.import_seconds = clock.lap();
  for (const std::string& warning : warnings) report_warning(warning);

  report.input = figures_of(mesh);
  for (int level = 0; level <= arguments.levels; ++level)
    report.level_counts.push_back(counts_at_level(mesh, level));
  plan.store.base_level = existing
                              ? existing->base_level()
                              : rebase_levels(arguments.levels, plan.double_precision ? 24 : 12,
                                              arguments.max_slot_bytes);
  if (existing) plan.layout = layout_from_name(existing->options().layout);
  if (plan.store.base_level > 0)
    mesh = rebase(mesh, plan.store.base_level, plan.subdivide.scheme, plan.double_precision);
  report.refine_seconds = clock.lap();

  LaidOutMesh laid_out = lay_out(mesh, plan.layout);
  report.layout_seconds = clock.lap();
  report.base = figures_of(laid_out.mesh);
  report.base_level = plan.store.base_level;
  report.layout = to_string(laid_out.kind);
  report.spans = laid_out.spans;
  plan.store.layout = report.layout;
  return laid_out;
}

void describe(const Arguments& arguments, const Plan& plan, Store& store, SubdivideReport& report) {
  report.mesh = arguments.mesh;
  report.store = plan.output ? plan.output->final_path() : store.path();
  report.levels = arguments.levels;
  report.paging = store.statistics();
  report.stored_bytes = store.stored_bytes();
  report.base_mesh_bytes =
      store.base().memory_bytes() + subdivide_resident_bytes(store, plan.subdivide);
  for (AttributeId id = 0; id < store.attributes().size(); ++id)
    report.base_mesh_bytes += store.base_bytes(id).size();
  report.budget_bytes = plan.store.budget_bytes;
  report.block_bytes = store.options().block_bytes;
  report.backend = store.options().backend;
  const bool compressed = store.backend_traits().compressed;
  report.codec = compressed ? store.options().backend_options.codec : "none";
  report.filter = compressed ? store.options().backend_options.filter : "none";
  report.durability = arguments.durability;
  report.executor = to_string(plan.subdivide.executor);
  report.threads = plan.subdivide.threads;
  report.scheme = plan.store.scheme;
  report.precision = arguments.precision;
  report.normals = arguments.normals;
  report.limit = arguments.limit;
}

/// What an earlier run left of this one; none if there is nothing of that name.
std::optional<Store> find_earlier_run(const Arguments& arguments, const Plan& plan,
                                      const CommandContext& context) {
  if (!arguments.resume || !std::filesystem::exists(arguments.store)) return {};
  // Nothing was committed: Store::create puts the new one in its place.
  if (!Store::has_commit(arguments.store)) return {};
  OpenOptions open;
  open.writable = true;
  open.budget_bytes = plan.store.budget_bytes;
  open.durability = plan.store.durability;
  return open_to_resume(arguments.store, open, plan.subdivide, plan.double_precision,
                        context.backends);
}

/// Refines and commits: once at the end, or, to be resumed, also the base mesh and every level.
void refine(Store& store, Plan& plan, bool by_levels, SubdivideReport& report) {
  Stopwatch clock;
  const auto commit = [&] {
    report.refine_seconds += clock.lap();
    throw_if_interrupted();
    store.commit();
    report.commit_seconds += clock.lap();
  };
  if (store.attributes().empty()) {
    add_base_positions(store, plan.double_precision);
    if (by_levels) commit();
  }
  report.resumed_level = store.finest_level();
  if (is_finished(store, plan.subdivide)) return by_levels ? void() : commit();
  if (by_levels) plan.subdivide.level_done = [&](int) { commit(); };
  Progress progress("subdivide", ProgressUnit::kVertices);
  plan.subdivide.proceed = [&](const SubdivideProgress& now) {
    return progress.update(now.vertices_done, now.vertices_total, now.phase);
  };
  try {
    subdivide(store, plan.subdivide);
    progress.clear();
    commit();
  } catch (const Error& error) {
    if (!by_levels || error.code() != ErrorCode::kCancelled) throw;
    throw Error(error.code(), std::string(error.what()) + "; what is committed of " +
                                  store.path().native() +
                                  " stays, and --resume goes on from there");
  }
}

Store create_store(const std::filesystem::path& path, BaseMesh mesh, Plan& plan,
                   const CommandContext& context) {
  if (!plan.output) return Store::create(path, std::move(mesh), plan.store, context.backends);
  return build_output(*plan.output, [&] {
    return Store::create(plan.output->make(), std::move(mesh), plan.store, context.backends);
  });
}

int run(const Arguments& arguments, const CommandContext& context) {
  Plan plan;
  make_plan(arguments, context.backends, plan);
  SubdivideReport report;
  {
    std::optional<Store> earlier = find_earlier_run(arguments, plan, context);
    LaidOutMesh laid_out =
        prepare_mesh(arguments, plan, earlier ? &*earlier : nullptr, context.json, report);
    if (earlier) require_same_mesh(*earlier, laid_out.mesh);
    const std::filesystem::path path = arguments.resume ? arguments.store : std::filesystem::path();
    Store store =
        earlier ? std::move(*earlier) : create_store(path, std::move(laid_out.mesh), plan, context);
    refine(store, plan, arguments.resume, report);
    describe(arguments, plan, store, report);
    const Stopwatch clock;
    if (arguments.digest) report.digest = digest_with_progress(store, "digest", arguments.threads);
    report.digest_seconds = clock.seconds();
    store.close();
  }
  throw_if_interrupted();
  if (plan.output) plan.output->publish(plan.store.durability == Durability::kCommit);
  report.peak_rss_bytes = peak_rss_bytes();
  report.cpu_seconds = cpu_seconds();
  report.seconds = seconds_since_start();
  print(context.json ? to_json(report).dump(2) + "\n" : to_text(report));
  return kExitDone;
}

void add_options(CLI::App& command, Arguments& arguments) {
  command.add_option("MESH", arguments.mesh, "PLY, OBJ or OFF, also .gz and .zst")->required();
  add_output_option(command, "STORE", arguments.store,
                    "The store to make, a directory; with --backend memory it may be left out");
  command.add_option("--levels", arguments.levels, "The level to reach, 1 to 20")
      ->required()
      ->check(CLI::Range(1, kMaxLevel));
  command.add_option("--backend", arguments.backend, "What keeps the levels (see below)")
      ->capture_default_str();
  command.add_option("--codec", arguments.codec, "none, lz4, zstd or zstd:LEVEL; default zstd:1");
  command.add_option("--filter", arguments.filter, "none or shuffle; default shuffle");
  add_size_option(command, "--memory", arguments.memory_bytes, "Budget for blocks in memory");
  command.add_option("--threads", arguments.threads, "Threads that compute")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str();
  command
      .add_option("--executor", arguments.executor,
                  "auto (fused; with --resume sweep), fused, sweep or transparent")
      ->capture_default_str();
  command
      .add_option(
          "--layout", arguments.layout,
          "Order of edges on disk: auto (what suits the executor), given, spatial, hilbert or rcm")
      ->capture_default_str();
  command.add_option("--scheme", arguments.scheme, "loop, butterfly or midpoint")
      ->capture_default_str();
  command.add_option("--precision", arguments.precision, "Of positions: float32 or float64")
      ->check(CLI::IsMember({"float32", "float64"}))
      ->capture_default_str();
  command.add_flag("--normals", arguments.normals, "Also compute unit normals");
  command.add_flag("--limit", arguments.limit, "Project positions to the limit surface (loop)");
  add_size_option(command, "--block", arguments.block_bytes, "Unit of I/O, a power of two");
  add_size_option(command, "--max-slot", arguments.max_slot_bytes,
                  "Refine the base mesh in memory until no slot of positions is larger");
  command
      .add_option("--durability", arguments.durability,
                  "commit: on the disk at the end; none: scratch, without waiting for the disk")
      ->check(CLI::IsMember({"commit", "none"}))
      ->capture_default_str();
  command.add_flag("--digest", arguments.digest,
                   "Also read everything back and tell its digest, as plait digest does");
  CLI::Option* const force = command.add_flag(
      "--force", arguments.force,
      "Replace STORE if it is a store; the old one goes when the new one is whole");
  command
      .add_flag("--resume", arguments.resume,
                "Commit every level under its final name, and go on from the last one committed if "
                "STORE is there; it keeps its backend, codec, block size and layout")
      ->excludes(force);
}

}  // namespace

void add_subdivide_command(CLI::App& program, CommandContext& context) {
  const auto arguments = std::make_shared<Arguments>();
  CLI::App* command = program.add_subcommand("subdivide", "Refine a mesh into a store");
  add_options(*command, *arguments);
  add_json_option(*command, context);
  command->footer(backend_help(context.backends) +
                  "\n"
                  "`seconds` is all that you wait, from the start of the program to its end.\n"
                  "\n"
                  "Examples:\n"
                  "  plait subdivide molecule.ply molecule.plait --levels 5 --normals\n"
                  "  plait subdivide bunny.ply bunny.plait --levels 4 --backend compressed "
                  "--codec lz4 --memory 64MiB\n"
                  "  plait subdivide spot.ply --levels 3 --backend memory --json\n"
                  "  plait subdivide statue.ply statue.plait --levels 6 --resume    again after a "
                  "crash");
  command->callback([arguments, &context] {
    context.run = [arguments, &context] { return run(*arguments, context); };
  });
}

}  // namespace plait
