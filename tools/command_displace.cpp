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

#include "base/text.h"
#include "command.h"
#include "console.h"
#include "conversion/copy_options.h"
#include "copy_arguments.h"
#include "displace/displace.h"
#include "interrupt.h"
#include "json_text.h"
#include "measure.h"
#include "plait/extend/copy_levels.h"
#include "plait/store.h"
#include "plait/store_info.h"
#include "progress.h"
#include "store/attribute_levels.h"
#include "store/new_output.h"

namespace plait {
namespace {

struct DisplaceArguments : CopyArguments {
  std::string kind = "noise";
  std::optional<double> amplitude;
  std::uint64_t seed = 1;
};

// Noise as that of a fine scanner: 5 to 8 units in the last place of a float32.
constexpr double kNoiseAmplitude = 3e-7, kFractalAmplitude = 0.005;

DisplaceOptions displacement(const DisplaceArguments& arguments, ProgressBar& progress) {
  DisplaceOptions options;
  options.kind = displacement_from_name(arguments.kind);
  options.amplitude = arguments.amplitude.value_or(
      options.kind == DisplacementKind::kNoise ? kNoiseAmplitude : kFractalAmplitude);
  options.seed = arguments.seed;
  options.threads = arguments.threads;
  options.progress = [&progress](const Progress& now) {
    return progress.update(now.done, now.total, now.phase);
  };
  return options;
}

/// The pipelines of the copy: those of the arguments, or of the source.
PipelinesOf pipelines_of_copy(const DisplaceArguments& arguments, const Store& source,
                              const RegisteredBackend& backend) {
  const PipelinesOf chosen =
      arguments.compress.empty() ? PipelinesOf() : pipelines_of(arguments.compress, source);
  std::map<std::string, LevelPipelines> pipelines;
  for (AttributeId id = 0; id < source.attributes().size(); ++id) {
    const AttributeSchema& schema = source.attributes()[id].schema;
    LevelPipelines& of_attribute = pipelines[schema.name];
    of_attribute = chosen                             ? chosen(schema)
                   : source.info().backend.compressed ? pipelines_of_levels(source, id)
                                                      : backend.default_pipeline;
    backend.check_pipelines(of_attribute, schema);
    // No scheme makes displaced positions.
    if (schema.name == "position")
      of_attribute.for_each([](Pipeline& one) { one = one.without_predicted_stage(); });
  }
  return [pipelines](const AttributeSchema& schema) { return pipelines.at(schema.name); };
}

/// The options of the copy: those of the source, unless an argument changes them.
StoreOptions options_of_copy(const DisplaceArguments& arguments, const Store& source,
                             const BackendRegistry& backends) {
  StoreOptions options = source.options();
  const CopyChoices choices = choices_of(arguments);
  options.backend = choose_backend_of_copy(choices, source, backends).name;
  const RegisteredBackend& backend =
      find_backend_of_copy(choices, options.backend, "displace", backends);
  options.pipeline = backend.default_pipeline;
  options.pipeline_of = {};
  if (backend.traits.compressed)
    options.pipeline_of = pipelines_of_copy(arguments, source, backend);
  set_common_options(choices, options);
  return options;
}

void print_displace(const DisplaceOptions& options, const Displaced& displaced,
                    const std::filesystem::path& store, std::uint64_t stored_bytes,
                    double seconds) {
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

nlohmann::ordered_json displace_json(const DisplaceArguments& arguments,
                                     const DisplaceOptions& options, const Displaced& displaced) {
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

int run_displace(const DisplaceArguments& arguments, const CommandContext& context) {
  const Stopwatch clock;
  ProgressBar progress("displace", ProgressUnit::kNone);
  const DisplaceOptions how = displacement(arguments, progress);
  Store source = open_source(arguments, context);
  const StoreOptions options = options_of_copy(arguments, source, context.backends);
  Displaced displaced;
  std::uint64_t stored_bytes = 0;
  const auto make = [&](const std::filesystem::path& path) {
    Store copy = Store::create(path, source.base(), options, context.backends, source.provenance());
    const auto show = [&](const char* phase) {
      return [&progress, phase](const Progress& now) {
        return progress.update(now.done, now.total, phase);
      };
    };
    copy_levels(source, copy, show("copy"), {}, true);
    source.close();
    displaced = displace(copy, how);
    copy.finish_encoding(show("encode"));
    copy.commit();
    stored_bytes = copy.info().stored_bytes;
    copy.close();
    progress.clear();
    throw_if_interrupted();
  };
  const std::filesystem::path made =
      make_new_store(arguments.to, arguments.force ? Existing::kReplace : Existing::kRefuse,
                     Durability::kCommit, report_warning, make);

  if (!context.json) {
    print_displace(how, displaced, made, stored_bytes, clock.seconds());
    return kExitDone;
  }
  nlohmann::ordered_json report = displace_json(arguments, how, displaced);
  report["store"] = made.string();
  report["backend"] = options.backend;
  report["stored_bytes"] = stored_bytes;
  report["seconds"] = clock.seconds();
  print(json_text(report));
  return kExitDone;
}

}  // namespace

void add_displace_command(CommandLine& program, CommandContext& context) {
  const auto arguments = std::make_shared<DisplaceArguments>();
  CommandLine* command = program.add_subcommand(
      "displace", "Copy a store and move its vertices, by noise or by a fractal");
  add_copy_options(*command, context, *arguments, "Worker threads");
  command->add_option("--kind", arguments->kind, "noise or fractal")->capture_default_str();
  command
      ->add_option("--amplitude", arguments->amplitude,
                   "How far, in diagonals of the bounding box, 0 to 1")
      ->range(0.0, 1.0)
      ->default_str("noise 3e-7, fractal 0.005");
  add_whole_option(*command, "--seed", arguments->seed, 0,
                   std::numeric_limits<std::uint64_t>::max(), "Each seed gives another surface")
      ->default_str(std::to_string(arguments->seed));
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
    context.run = [arguments, &context] { return run_displace(*arguments, context); };
  });
}

}  // namespace plait
