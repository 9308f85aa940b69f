// plait subdivide: a mesh in, a store out.

#include <fmt/format.h>

#include <memory>
#include <string>
#include <utility>

#include "arguments.h"
#include "command.h"
#include "console.h"
#include "interrupt.h"
#include "measure.h"
#include "plait/edge_index.h"
#include "progress.h"
#include "read_back.h"
#include "subdivide/job.h"

namespace plait {
namespace {

int run(const SubdivisionRequest& request, const CommandContext& context) {
  Progress progress("subdivide", ProgressUnit::kVertices);
  SubdivisionEvents events;
  events.warning = report_warning;
  events.proceed = [&](const SubdivideProgress& now) {
    return progress.update(now.vertices_done, now.vertices_total, now.phase);
  };
  SubdivisionJob job(request, context.backends, events);
  {
    const EndAtOnce nothing_is_made_yet(context.json);
    job.prepare();
  }
  job.refine();
  progress.clear();
  SubdivideReport& report = job.report();
  if (request.digest) {
    const Stopwatch clock;
    report.digest = digest_with_progress(job.store(), "digest", request.threads);
    report.digest_seconds = clock.seconds();
  }
  throw_if_interrupted();
  job.finish();
  report.peak_rss_bytes = peak_rss_bytes();
  report.cpu_seconds = cpu_seconds();
  report.seconds = seconds_since_start();
  print(context.json ? to_json(report).dump(2) + "\n" : to_text(report));
  return kExitDone;
}

void add_surface_options(CLI::App& command, SubdivisionRequest& request) {
  add_whole_option(command, "--levels", request.levels, 1, kMaxLevel,
                   fmt::format("The level to reach, 1 to {}", kMaxLevel))
      ->required();
  command.add_option("--scheme", request.scheme,
                     fmt::format("{}; default {}", scheme_names(), to_string(Scheme::kLoop)));
  command
      .add_option("--precision", request.precision,
                  "Of positions: float32 or float64; default float32")
      ->check(CLI::IsMember({"float32", "float64"}));
  command.add_flag("--normals", request.normals, "Also compute unit normals");
  command.add_flag("--limit", request.limit, "Project positions to the limit surface (loop)");
}

void add_storage_options(CLI::App& command, SubdivisionRequest& request) {
  command.add_option("--backend", request.backend,
                     "What keeps the levels (see below); default auto");
  command.add_option("--codec", request.codec,
                     "none, lz4, zstd or zstd:LEVEL; default zstd:1; with --backend compressed");
  command.add_option("--filter", request.filter,
                     "none or shuffle; default shuffle; with --backend compressed");
  command.add_option(
      "--layout", request.layout,
      "Order of edges on disk: auto (what suits the executor; default), given, spatial, hilbert or "
      "rcm");
  add_size_option(command, "--block", request.block_bytes,
                  "Unit of I/O, a power of two; default 1MiB");
  add_size_option(command, "--max-slot", request.max_slot_bytes,
                  "Refine the base mesh in memory until no slot of positions is larger; default "
                  "16KiB");
  command
      .add_option_function<std::string>(
          "--durability", [&](const std::string& name) { request.durable = name == "commit"; },
          "commit: on the disk at the end; none: scratch, without waiting for the disk")
      ->check(CLI::IsMember({"commit", "none"}))
      ->default_str("commit");
}

void add_run_options(CLI::App& command, SubdivisionRequest& request) {
  add_size_option(command, "--memory", request.memory_bytes, "Budget for blocks in memory");
  add_threads_option(command, request.threads, "Threads that compute");
  command
      .add_option("--executor", request.executor,
                  "auto (fused; with --resume sweep), fused, sweep or transparent")
      ->capture_default_str();
  command.add_flag("--digest", request.digest,
                   "Also read everything back and tell its digest, as plait digest does");
  command.add_flag("--ignore-size", request.ignore_size,
                   "Begin although memory, disk or budget are too small for the last level");
  CLI::Option* const force = command.add_flag(
      "--force", request.force,
      "Replace STORE if it is a store; the old one goes when the new one is whole");
  command
      .add_flag("--resume", request.resume,
                "Commit every level under its final name, and go on from the last one committed if "
                "STORE is there: interrupted, or finished at a coarser level")
      ->excludes(force);
}

}  // namespace

void add_subdivide_command(CLI::App& program, CommandContext& context) {
  const auto request = std::make_shared<SubdivisionRequest>();
  request->threads = default_thread_count();
  CLI::App* command = program.add_subcommand("subdivide", "Refine a mesh into a store");
  command->add_option("MESH", request->mesh, "PLY, OBJ or OFF, also .gz and .zst")->required();
  add_output_option(*command, "STORE", request->store,
                    "The store to make, a directory; with --backend memory it may be left out");
  add_surface_options(*command, *request);
  add_storage_options(*command, *request);
  add_run_options(*command, *request);
  add_json_option(*command, context);
  command->footer(
      backend_help(context.backends) +
      "  auto         uring for a store that is large beside the memory available, where the\n"
      "               kernel and the file system have it; else pread. The files are the same.\n"
      "\n"
      "--resume takes scheme, precision, backend, codec, filter, layout, block size and base mesh\n"
      "from the store, and refuses options that differ. Normals that are there are made anew\n"
      "(--normals) in the one commit that ends a step to finer levels.\n"
      "Before it begins it compares what it needs with the budget, the memory available and the\n"
      "free space of the disk (--ignore-size: and begins all the same).\n"
      "`seconds` is all that you wait, from the start of the program to its end.\n"
      "\n"
      "Examples:\n"
      "  plait subdivide molecule.ply molecule.plait --levels 5 --normals\n"
      "  plait subdivide bunny.ply bunny.plait --levels 4 --backend compressed "
      "--codec lz4 --memory 64MiB\n"
      "  plait subdivide spot.ply --levels 3 --backend memory --digest --json\n"
      "  plait subdivide statue.ply statue.plait --levels 6 --resume    again after a "
      "crash\n"
      "  plait subdivide statue.ply statue.plait --levels 7 --resume    one level more");
  command->callback([request, &context] {
    context.run = [request, &context] { return run(*request, context); };
  });
}

}  // namespace plait
