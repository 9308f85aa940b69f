// plait displace: copies a store and moves the vertices of the copy.

#include <fmt/format.h>

#include <filesystem>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "arguments.h"
#include "command.h"
#include "console.h"
#include "interrupt.h"
#include "measure.h"
#include "plait/byte_text.h"
#include "plait/copy_levels.h"
#include "plait/kernels/displace.h"
#include "plait/left_overs.h"
#include "plait/partial_store.h"
#include "plait/recode_attribute.h"
#include "plait/store.h"
#include "progress.h"

namespace plait {
namespace {

struct Arguments {
  std::filesystem::path from, to;
  std::string backend;                ///< empty: the same as the source
  std::vector<std::string> compress;  ///< empty: the same as the source
  std::uint64_t block_bytes = 0;      ///< 0: the same as the source
  std::uint64_t memory_bytes = StoreOptions().budget_bytes;
  int threads = default_thread_count();
  bool force = false;
  std::string kind = "noise";
  std::optional<double> amplitude;
  std::uint64_t seed = 1;
};

// Noise as that of a fine scanner: 5 to 8 units in the last place of a float32.
constexpr double kNoiseAmplitude = 3e-7, kFractalAmplitude = 0.005;

DisplaceOptions displacement(const Arguments& arguments, Progress& progress) {
  DisplaceOptions options;
  options.kind = displacement_from_name(arguments.kind);
  options.amplitude = arguments.amplitude.value_or(
      options.kind == DisplacementKind::kNoise ? kNoiseAmplitude : kFractalAmplitude);
  options.seed = arguments.seed;
  options.threads = arguments.threads;
  options.proceed = [&progress](std::string_view phase, std::uint64_t done, std::uint64_t total) {
    return progress.update(done, total, phase);
  };
  return options;
}

using PipelineOf = std::function<std::string(const AttributeSchema&)>;

/// The options of the copy: those of the source, unless an argument changes them. Until the
/// vertices have moved, its levels have the backend's own pipeline, which needs no other blocks.
StoreOptions options_of_copy(const Arguments& arguments, const Store& source,
                             const BackendRegistry& backends) {
  StoreOptions options = source.options();
  if (!arguments.backend.empty())
    options.backend = arguments.backend;
  else if (!arguments.compress.empty())
    options.backend = "compressed";
  const BackendRegistry::Entry& backend = backends.find(options.backend);
  if (!backend.traits.durable)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("displace: backend {} writes no files", backend.name));
  if (!backend.traits.compressed && !arguments.compress.empty())
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("displace: --compress needs a backend that compresses, and {} does "
                            "not: add --backend compressed",
                            backend.name));
  backend.validate(BackendRegistry::options_in(options.backend));
  options.pipeline = backend.default_pipeline;
  options.pipeline_of = {};
  if (arguments.block_bytes != 0) options.block_bytes = arguments.block_bytes;
  options.budget_bytes = arguments.memory_bytes / 2;
  options.durability = Durability::kCommit;
  std::error_code ignored;
  if (std::filesystem::equivalent(arguments.from, arguments.to, ignored))
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("displace {}: source and copy are the same", arguments.from.native()));
  return options;
}

/// The pipelines of the finished copy, by the names of attributes.
std::map<std::string, std::string> pipelines_of_copy(const Arguments& arguments,
                                                     const Store& source,
                                                     const BackendRegistry::Entry& backend) {
  std::map<std::string, std::string> pipelines;
  if (!backend.traits.compressed) return pipelines;
  PipelineOf chosen;
  if (!arguments.compress.empty()) chosen = pipelines_of(arguments.compress);
  for (AttributeId id = 0; id < source.attributes().size(); ++id) {
    const auto& [schema, finest] = source.attributes()[id];
    if (finest == source.base_level()) continue;
    std::string& pipeline = pipelines[schema.name];
    pipeline = chosen                               ? chosen(schema)
               : source.backend_traits().compressed ? source.level_file(id, finest).pipeline
                                                    : backend.default_pipeline;
    backend.validate_pipeline(pipeline, schema);
  }
  return pipelines;
}

void encode_anew(Store& store, const std::map<std::string, std::string>& pipelines,
                 Progress& progress) {
  // Normals are encoded from positions, which come earlier.
  for (AttributeId id = 0; id < store.attributes().size(); ++id) {
    const auto& [schema, finest] = store.attributes()[id];
    const auto pipeline = pipelines.find(schema.name);
    if (pipeline == pipelines.end() || store.level_file(id, finest).pipeline == pipeline->second)
      continue;
    recode_attribute(store, id, pipeline->second, [&](std::uint64_t done, std::uint64_t total) {
      return progress.update(done, total, "encode");
    });
  }
}

void print_report(const DisplaceOptions& options, const Displaced& displaced,
                  const std::filesystem::path& store, std::uint64_t stored_bytes, double seconds) {
  const std::string waves =
      displaced.wavelengths.empty()
          ? ""
          : fmt::format(", {} octaves of waves from {:.4g} to {:.4g}", displaced.wavelengths.size(),
                        displaced.wavelengths.front(), displaced.wavelengths.back());
  print(
      fmt::format("{}: {} of {:g} diagonals{}, seed {}; the longest way is {:.4g}, the diagonal "
                  "{:.4g}; {}, {:.2f} s\n",
                  store.native(), to_string(options.kind), options.amplitude, waves, options.seed,
                  displaced.largest_move, displaced.diagonal, format_bytes(stored_bytes), seconds));
}

nlohmann::ordered_json json_report(const Arguments& arguments, const DisplaceOptions& options,
                                   const Displaced& displaced) {
  nlohmann::ordered_json report = {
      {"from", arguments.from.string()}, {"kind", to_string(options.kind)},
      {"amplitude", options.amplitude},  {"seed", options.seed},
      {"diagonal", displaced.diagonal},  {"largest_move", displaced.largest_move}};
  if (options.kind == DisplacementKind::kFractal) {
    report["mean_edge"] = displaced.mean_edge;
    report["wavelengths"] = displaced.wavelengths;
  }
  return report;
}

int run(const Arguments& arguments, const CommandContext& context) {
  const Stopwatch clock;
  Progress progress("displace", ProgressUnit::kNone);
  const DisplaceOptions how = displacement(arguments, progress);
  OpenOptions open;
  // The two stores share the budget of --memory.
  open.budget_bytes = arguments.memory_bytes / 2;
  Store source = Store::open(arguments.from, open, context.open_backends);
  const StoreOptions options = options_of_copy(arguments, source, context.backends);
  const auto pipelines =
      pipelines_of_copy(arguments, source, context.backends.find(options.backend));
  PartialStore output(arguments.to, arguments.force ? Existing::kReplace : Existing::kRefuse);
  remove_left_overs_of(arguments.to, report_warning);

  Displaced displaced;
  std::uint64_t stored_bytes = 0;
  build_output(output, [&] {
    Store copy = Store::create(output.make(), source.base(), options, context.backends);
    copy_levels(source, copy, [&](std::uint64_t done, std::uint64_t total) {
      return progress.update(done, total, "copy");
    });
    source.close();
    displaced = displace(copy, how);
    encode_anew(copy, pipelines, progress);
    copy.commit();
    stored_bytes = copy.stored_bytes();
    copy.close();
  });
  progress.clear();
  throw_if_interrupted();
  output.publish(true, report_warning);

  if (!context.json) {
    print_report(how, displaced, output.final_path(), stored_bytes, clock.seconds());
    return kExitDone;
  }
  nlohmann::ordered_json report = json_report(arguments, how, displaced);
  report["store"] = output.final_path().string();
  report["backend"] = options.backend;
  report["stored_bytes"] = stored_bytes;
  report["seconds"] = clock.seconds();
  print(report.dump(2) + "\n");
  return kExitDone;
}

}  // namespace

void add_displace_command(CommandLine& program, CommandContext& context) {
  const auto arguments = std::make_shared<Arguments>();
  CommandLine* command = program.add_subcommand(
      "displace", "Copy a store and move its vertices, by noise or by a fractal");
  command->add_option("STORE", arguments->from, "The store to copy")->required();
  add_output_option(*command, "OUT", arguments->to, "The store to make")->required();
  command->add_option("--kind", arguments->kind, "noise or fractal")->capture_default_str();
  command
      ->add_option("--amplitude", arguments->amplitude,
                   "How far, in diagonals of the bounding box, 0 to 1")
      ->range(0.0, 1.0)
      ->default_str("noise 3e-7, fractal 0.005");
  add_whole_option(*command, "--seed", arguments->seed, 0,
                   std::numeric_limits<std::uint64_t>::max(), "Each seed gives another surface")
      ->default_str(std::to_string(arguments->seed));
  command->add_option("--backend", arguments->backend, "The backend of the copy (see below)")
      ->default_str("as in STORE");
  add_compress_option(*command, arguments->compress);
  add_size_option(*command, "--block", arguments->block_bytes, "Unit of I/O, a power of two")
      ->default_str("as in STORE");
  add_size_option(*command, "--memory", arguments->memory_bytes,
                  "Budget for blocks in memory, half of it for each store");
  add_threads_option(*command, arguments->threads, "Worker threads");
  command->add_flag("--force", arguments->force,
                    "Replace OUT if it is a store, when the new store is complete");
  add_plugin_option(*command, context);
  add_json_option(*command, context);
  command->footer(
      backend_help(context.backends) + compression_help() +
      "\n"
      "noise moves each coordinate by up to the amplitude. fractal moves vertices along the\n"
      "normals, in waves from an eighth of the diagonal down to four mean edges of the finest\n"
      "level: the longest waves have the amplitude, the next ones, half as long, 0.45 of it.\n"
      "If STORE has normals, those of OUT are made anew. The same seed gives the same surface for\n"
      "every backend, layout and number of threads. Everything else is as in STORE.\n"
      "\n"
      "Examples:\n"
      "  plait displace surface.plait scanned.plait --amplitude 3e-7\n"
      "  plait displace surface.plait rocks.plait --kind fractal --amplitude 0.01 --seed 7");
  command->callback([arguments, &context] {
    context.run = [arguments, &context] { return run(*arguments, context); };
  });
}

}  // namespace plait
