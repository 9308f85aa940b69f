// plait compare: the distances between two surfaces, in both directions.

#include <fmt/format.h>

#include <memory>
#include <string>

#include "arguments.h"
#include "command.h"
#include "compare/compare.h"
#include "console.h"
#include "json_text.h"
#include "measure.h"
#include "progress.h"
#include "scan_report.h"

namespace plait {
namespace {

int run_compare(const ComparisonRequest& request, const CommandContext& context) {
  SurfaceComparison found;
  {
    ProgressBar progress("compare", ProgressUnit::kNone);
    found = compare_surfaces(
        request, context.open_backends,
        {.progress =
             [&](const Progress& now) { return progress.update(now.done, now.total, now.phase); },
         .warn =
             [&](const std::string& what) {
               progress.clear();
               report_warning(what);
             }});
  }
  if (context.json) {
    const nlohmann::ordered_json report = {{"a", request.first.string()},
                                           {"b", request.second.string()},
                                           {"diagonal", found.diagonal},
                                           {"mean_edge", found.mean_edge},
                                           {"a_to_b", distances_json(found.there, found.diagonal)},
                                           {"b_to_a", distances_json(found.back, found.diagonal)},
                                           {"seconds", seconds_since_start()}};
    print(json_text(report));
    return kExitDone;
  }
  print(fmt::format("{}{}diagonal {:.6g}, mean edge {:.6g} of {}; {} samples in each direction\n",
                    distances_text("A to B", found.there, found.diagonal, found.mean_edge),
                    distances_text("B to A", found.back, found.diagonal, found.mean_edge),
                    found.diagonal, found.mean_edge, request.first.native(),
                    format_count(request.samples)));
  return kExitDone;
}

}  // namespace

void add_compare_command(CommandLine& program, CommandContext& context) {
  const auto request = std::make_shared<ComparisonRequest>();
  request->threads = default_thread_count();
  CommandLine* command =
      program.add_subcommand("compare", "Measure the distances between two surfaces");
  command->add_option("A", request->first, "A mesh file or a store")->required();
  command->add_option("B", request->second, "A mesh file or a store")->required();
  add_level_option(*command, request->level, "The level of stores; default: the finest");
  add_whole_option(*command, "--samples", request->samples, 1, 1000000000,
                   "Points on each surface, spread by area")
      ->default_str("1000000");
  add_threads_option(*command, request->threads, "Worker threads");
  add_plugin_option(*command, context);
  add_json_option(*command, context);
  command->footer(
      "Each sample is a point of one surface; its distance is that to the closest point of the\n"
      "other one. The two directions differ where one surface has parts that the other lacks.\n"
      "Percentages are of the diagonal of the box around A. The surfaces have to fit in memory.\n"
      "\n"
      "Examples:\n"
      "  plait compare scan.ply scan.plait\n"
      "  plait compare scan.ply scan.plait --level 2 --samples 10000000");
  command->callback([request, &context] {
    context.run = [request, &context] { return run_compare(*request, context); };
  });
}

}  // namespace plait
