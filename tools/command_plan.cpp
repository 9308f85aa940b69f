// plait plan: cuts a subdivision, or a pass over a store in shards, into parts that many machines
// can make.

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <initializer_list>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <system_error>
#include <vector>

#include "argument_text.h"
#include "arguments.h"
#include "base/byte_text.h"
#include "command.h"
#include "compress_arguments.h"
#include "console.h"
#include "interrupt.h"
#include "io/partial_output.h"
#include "measure.h"
#include "parts_script.h"
#include "plait/error.h"
#include "plait/extend/edge_index.h"
#include "plait/extend/parts.h"

namespace plait {
namespace {

struct PlanArguments {
  PartsRequest request;
  std::optional<std::string> scheme, precision, layout, pass;
  std::vector<std::string> compress;
  Pass options;  ///< of the pass
  std::optional<double> diagonal;
  int parts = 1;
  std::filesystem::path sbatch;
  int tasks = 1000;
};

PartsRequest request_of(const PlanArguments& arguments) {
  PartsRequest request = arguments.request;
  request.parts = static_cast<std::uint32_t>(arguments.parts);
  if (arguments.scheme) request.scheme = scheme_from_name(*arguments.scheme);
  if (arguments.layout) request.layout = layout_from_name(*arguments.layout);
  if (arguments.precision && *arguments.precision == "float64")
    request.precision = ComponentType::kFloat64;
  if (!arguments.compress.empty()) request.pipeline_of = pipelines_of(arguments.compress);
  return request;
}

PassRequest pass_request_of(const PlanArguments& arguments) {
  PassRequest request;
  request.store = arguments.request.mesh;
  request.plan = arguments.request.plan;
  request.pass = arguments.options;
  request.pass.name = *arguments.pass;
  request.threads = default_thread_count();
  return request;
}

double ghost_share(const PlannedPart& part) {
  return static_cast<double>(part.ghosts) / static_cast<double>(part.faces);
}

/// No plan stays without the script that was asked for.
template <class Step>
void remove_plan_unless(const std::filesystem::path& plan, const Step& succeeds) try {
  succeeds();
} catch (const Error&) {
  std::error_code ignored;
  std::filesystem::remove_all(plan, ignored);
  throw;
}

int run_plan(const PlanArguments& arguments, const CommandContext& context) {
  const Stopwatch clock;
  const bool has_script = !arguments.sbatch.empty();
  if (has_script) PartialFile::check(arguments.sbatch, Existing::kRefuse);
  std::optional<SbatchScript> script;
  PartsPlan plan;
  {
    EndAtOnce nothing_is_made_yet(context.json);
    const auto go_on = [](const Progress&) { return !interrupted(); };
    const auto make_script = [&](std::size_t parts) {
      if (has_script)
        script.emplace(arguments.sbatch, arguments.request.plan, static_cast<std::uint32_t>(parts),
                       static_cast<std::uint32_t>(arguments.tasks));
    };
    if (arguments.pass) {
      PassRequest request = pass_request_of(arguments);
      request.progress = go_on;
      request.before_files = [&] { nothing_is_made_yet.end(); };
      plan = plan_pass(request, context.backends);
      remove_plan_unless(arguments.request.plan, [&] { make_script(plan.parts.size()); });
    } else {
      PartsRequest request = request_of(arguments);
      request.progress = go_on;
      request.before_files = [&] {
        nothing_is_made_yet.end();
        make_script(request.parts);
      };
      plan = plan_parts(request, context.backends);
    }
  }
  for (const std::string& warning : plan.warnings) report_warning(warning);
  if (script) remove_plan_unless(arguments.request.plan, [&] { script->publish(); });
  std::uint64_t bytes = 0, faces = 0, ghosts = 0;
  double seconds = 0;
  for (const PlannedPart& part : plan.parts) {
    bytes += part.bytes;
    faces += part.faces;
    ghosts += part.ghosts;
    seconds += part.seconds;
  }
  const auto worst = std::ranges::max_element(plan.parts, {}, &PlannedPart::seconds);
  const auto number = worst - plan.parts.begin();
  const double share = static_cast<double>(ghosts) / static_cast<double>(faces);
  if (!context.json) {
    if (plan.pass)
      print(fmt::format("pass {} over version {} of {} makes '{}'\n", plan.pass->pass.name,
                        plan.pass->version, plan.pass->store.native(), plan.pass->result.name));
    if (plan.rates)
      print(fmt::format(
          "this machine, one thread: {:.1f} M points/s, {}/s written and synced, {:.2g} s "
          "to begin a part (measured)\n",
          1e-6 * plan.rates->points_per_second,
          format_bytes(static_cast<std::uint64_t>(plan.rates->bytes_per_second)),
          plan.rates->begin_seconds));
    const auto line = [](std::size_t part, const PlannedPart& figures) {
      return fmt::format("part {}: edges {} to {}, {}, {:.1f} % ghosts, about {:.3g} s\n", part,
                         figures.first_edge, figures.edge_after, format_bytes(figures.bytes),
                         100 * ghost_share(figures), figures.seconds);
    };
    constexpr std::size_t kMostLines = 16;
    if (plan.parts.size() <= kMostLines)
      for (std::size_t at = 0; at < plan.parts.size(); ++at) print(line(at, plan.parts[at]));
    else
      print("the worst: " + line(static_cast<std::size_t>(number), *worst));
    print(
        fmt::format("{}: {} parts, level {}, {} vertices, {} in {} files, {:.1f} % ghosts, about "
                    "{:.3g} s in all and {:.3g} s for the worst part ({})\n",
                    arguments.request.plan.native(), plan.parts.size(), plan.levels, plan.vertices,
                    format_bytes(bytes), plan.files, 100 * share, seconds, worst->seconds,
                    plan.rates ? "one thread of this machine"
                               : "estimates for one thread of an ordinary machine"));
    return kExitDone;
  }
  nlohmann::ordered_json report = {
      {"plan", arguments.request.plan.string()},
      {"levels", plan.levels},
      {"base_level", plan.base_level},
      {"vertices", plan.vertices},
      {"backend", plan.backend},
      {"files", plan.files},
      {"bytes", bytes},
      {"ghost_faces", ghosts},
      {"seconds_of_parts", seconds},
      {"worst", {{"part", number}, {"bytes", worst->bytes}, {"seconds", worst->seconds}}},
      {"seconds", clock.seconds()}};
  if (plan.pass) {
    report["pass"] = plan.pass->pass.name;
    report["store"] = plan.pass->store.string();
    report["version"] = plan.pass->version;
    report["attribute"] = plan.pass->result.name;
    if (plan.pass->pass.diagonal) report["diagonal"] = *plan.pass->pass.diagonal;
  }
  if (plan.rates)
    report["rates"] = {{"points_per_second", plan.rates->points_per_second},
                       {"bytes_per_second", plan.rates->bytes_per_second},
                       {"begin_seconds", plan.rates->begin_seconds}};
  report["parts"] = nlohmann::ordered_json::array();
  for (const PlannedPart& part : plan.parts)
    report["parts"].push_back({{"first_edge", part.first_edge},
                               {"edge_after", part.edge_after},
                               {"records", part.records},
                               {"faces", part.faces},
                               {"ghost_faces", part.ghosts},
                               {"bytes", part.bytes},
                               {"seconds", part.seconds}});
  print(report.dump(2) + "\n");
  return kExitDone;
}

/// Options of a subdivision have no meaning for a pass, and the other way round.
void check_kind(const CommandLine& command, bool is_pass) {
  for (const char* const name : {"--levels", "--parts"})
    if (!is_pass && !command.given(name)) throw UsageError(fmt::format("{} is required", name));
  const auto refuse = [&](std::initializer_list<const char*> names, const char* reason) {
    for (const char* const name : names)
      if (command.given(name)) throw UsageError(fmt::format("{}: {}", name, reason));
  };
  if (is_pass)
    refuse({"--levels", "--parts", "--scheme", "--precision", "--normals", "--limit", "--layout",
            "--compress", "--block", "--max-slot", "--calibrate"},
           "a pass has the levels, shards and blocks of its store");
  else
    refuse({"--factor", "--amplitude", "--seed", "--diagonal"}, "this is an option of --pass");
}

}  // namespace

void add_plan_command(CommandLine& program, CommandContext& context) {
  const auto arguments = std::make_shared<PlanArguments>();
  CommandLine* command =
      program.add_subcommand("plan", "Cut a subdivision or a pass into parts for many machines");
  command
      ->add_option("INPUT", arguments->request.mesh,
                   "PLY, OBJ or OFF, also .gz and .zst; for --pass a store in shards")
      ->required();
  add_output_option(*command, "PLAN", arguments->request.plan, "The plan to make, a directory")
      ->required();
  add_whole_option(*command, "--levels", arguments->request.levels, 1, kMaxLevel,
                   fmt::format("The level to reach, 1 to {}", kMaxLevel));
  add_whole_option(*command, "--parts", arguments->parts, 1, 1 << 20, "The number of parts");
  command->add_option("--scheme", arguments->scheme, "The scheme; default loop");
  command
      ->add_option("--precision", arguments->precision,
                   "Type of the positions: float32 or float64; default float32")
      ->one_of({"float32", "float64"});
  command->add_flag("--normals", arguments->request.normals, "Also compute unit normals");
  command->add_flag("--limit", arguments->request.limit,
                    "Project positions to the limit surface, if the scheme has one");
  command->add_option("--layout", arguments->layout,
                      "Order of edges: given, spatial, hilbert or rcm; default hilbert");
  add_compress_option(*command, arguments->compress);
  add_size_option(*command, "--block", arguments->request.block_bytes,
                  "Unit of I/O, a power of two; default 1MiB");
  add_size_option(*command, "--max-slot", arguments->request.max_slot_bytes,
                  "Largest slot of positions: refine the base mesh in memory until all slots fit; "
                  "default 16KiB");
  command
      ->add_option("--pass", arguments->pass,
                   "Plan a pass over all vertices of a store: smooth, noise or normals")
      ->one_of({"smooth", "noise", "normals"});
  command
      ->add_option("--factor", arguments->options.factor,
                   "smooth: how far each vertex goes to the mean of its neighbours, 0 to 1")
      ->range(0.0, 1.0)
      ->capture_default_str();
  command
      ->add_option("--amplitude", arguments->options.amplitude,
                   "noise: how far, in diagonals of the bounding box, 0 to 1")
      ->range(0.0, 1.0)
      ->default_str("3e-7");
  add_whole_option(*command, "--seed", arguments->options.seed, 0,
                   std::numeric_limits<std::uint64_t>::max(),
                   "noise: each seed gives another surface")
      ->default_str("1");
  command->add_option("--diagonal", arguments->diagonal,
                      "noise: that of the bounding box; default: plan reads all positions once");
  command->add_flag("--calibrate", arguments->request.calibrate,
                    "Measure this machine for about two seconds: seconds are then its own");
  command->add_option("--sbatch", arguments->sbatch,
                      "Also write a Slurm script that makes all parts in an array job");
  add_whole_option(*command, "--array", arguments->tasks, 1, 1 << 20,
                   "The longest array that --sbatch may ask for; default 1000");
  add_plugin_option(*command, context);
  add_json_option(*command, context);
  command->footer(
      "plait part makes each part, on any machine that sees PLAN, in any order; plait join makes\n"
      "the store of them. The store's digest is that of plait subdivide with the same options.\n"
      "Parts have raw blocks, or with --compress blocks of a pipeline without prediction: fast.\n"
      "\n"
      "With --pass, the parts are the shards of a store that plait join has made, and plait join\n"
      "commits its next version. A pass reads the last commit, so five iterations are five plans,\n"
      "one after another. smooth and noise replace the positions. normals makes or replaces the\n"
      "normals; no other pass does.\n"
      "\n"
      "Examples:\n"
      "  plait plan --pass smooth --factor 0.3 molecule.plait smooth1.plan\n"
      "  plait plan --pass normals molecule.plait normals.plan --sbatch normals.sh\n"
      "  plait plan molecule.ply molecule.plan --levels 5 --normals --parts 4\n"
      "  plait plan statue.ply statue.plan --levels 8 --parts 1000 --calibrate --sbatch statue.sh");
  command->callback([arguments, command, &context] {
    check_kind(*command, arguments->pass.has_value());
    arguments->options.diagonal = arguments->diagonal;
    context.run = [arguments, &context] { return run_plan(*arguments, context); };
  });
}

}  // namespace plait
