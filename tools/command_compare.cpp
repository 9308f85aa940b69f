// plait compare: the distances between two surfaces, in both directions.

#include <fmt/format.h>
#include <tbb/task_arena.h>

#include <filesystem>
#include <memory>
#include <string>

#include "arguments.h"
#include "command.h"
#include "console.h"
#include "interrupt.h"
#include "measure.h"
#include "plait/error.h"
#include "progress.h"
#include "scan_report.h"
#include "triangles.h"

namespace plait {
namespace {

struct CompareArguments {
  std::filesystem::path first, second;
  int level = -1;
  std::uint64_t samples = 1000000;
  int threads = default_thread_count();
};

/// A surface, and what the other one is measured against.
struct Side {
  IndexedMesh mesh;
  TriangleSet triangles() const { return {mesh.positions, mesh.faces}; }
};

Side read_side(const std::filesystem::path& path, const CompareArguments& arguments,
               const CommandContext& context) {
  std::error_code ignored;
  const bool is_store = std::filesystem::is_directory(path, ignored);
  Side side{read_triangles(path, is_store ? arguments.level : -1, context.open_backends)};
  for (const auto& face : side.mesh.faces)
    for (const VertexId vertex : face)
      if (vertex >= side.mesh.positions.size())
        throw Error(ErrorCode::kInvalidArgument,
                    fmt::format("{}: expected a vertex below {}, found {}", path.native(),
                                side.mesh.positions.size(), vertex));
  if (side.mesh.faces.empty())
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("{}: expected at least one face, found none", path.native()));
  return side;
}

int run_compare(const CompareArguments& arguments, const CommandContext& context) {
  const Side first = read_side(arguments.first, arguments, context);
  const Side second = read_side(arguments.second, arguments, context);
  throw_if_interrupted();
  const double diagonal = diagonal_of(first.triangles());
  const double mean_edge = mean_edge_of(first.triangles());
  Distances there, back;
  {
    ProgressBar progress("compare", ProgressUnit::kNone);
    tbb::task_arena(arguments.threads).execute([&] {
      DistanceOptions options{.samples = arguments.samples};
      options.progress = [&](const Progress& now) {
        return progress.update(now.done, 2 * now.total, "distance of A to B");
      };
      there = measure_distances(first.triangles(),
                                TriangleTree(second.mesh.positions, second.mesh.faces),
                                second.triangles(), options);
      options.progress = [&](const Progress& now) {
        return progress.update(now.total + now.done, 2 * now.total, "distance of B to A");
      };
      back = measure_distances(second.triangles(),
                               TriangleTree(first.mesh.positions, first.mesh.faces),
                               first.triangles(), options);
    });
  }
  if (context.json) {
    const nlohmann::ordered_json report = {{"a", arguments.first.string()},
                                           {"b", arguments.second.string()},
                                           {"diagonal", diagonal},
                                           {"mean_edge", mean_edge},
                                           {"a_to_b", distances_json(there, diagonal)},
                                           {"b_to_a", distances_json(back, diagonal)},
                                           {"seconds", seconds_since_start()}};
    print(report.dump(2) + "\n");
    return kExitDone;
  }
  print(fmt::format("{}{}diagonal {:.6g}, mean edge {:.6g} of {}; {} samples in each direction\n",
                    distances_text("A to B", there, diagonal, mean_edge),
                    distances_text("B to A", back, diagonal, mean_edge), diagonal, mean_edge,
                    arguments.first.native(), format_count(arguments.samples)));
  return kExitDone;
}

}  // namespace

void add_compare_command(CommandLine& program, CommandContext& context) {
  const auto arguments = std::make_shared<CompareArguments>();
  CommandLine* command =
      program.add_subcommand("compare", "Measure the distances between two surfaces");
  command->add_option("A", arguments->first, "A mesh file or a store")->required();
  command->add_option("B", arguments->second, "A mesh file or a store")->required();
  add_level_option(*command, arguments->level, "The level of stores; default: the finest");
  add_whole_option(*command, "--samples", arguments->samples, 1, 1000000000,
                   "Points on each surface, spread by area")
      ->default_str("1000000");
  add_threads_option(*command, arguments->threads, "Worker threads");
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
  command->callback([arguments, &context] {
    context.run = [arguments, &context] { return run_compare(*arguments, context); };
  });
}

}  // namespace plait
