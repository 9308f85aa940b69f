// plait convert: copies a store into another backend, compression or block size.

#include <fmt/format.h>

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "command.h"
#include "compress_arguments.h"
#include "console.h"
#include "copy_arguments.h"
#include "derived_attributes.h"
#include "interrupt.h"
#include "measure.h"
#include "plait/attribute_levels.h"
#include "plait/backends/compression.h"
#include "plait/byte_text.h"
#include "plait/copy_levels.h"
#include "plait/derivation.h"
#include "plait/left_overs.h"
#include "plait/partial_store.h"
#include "plait/rounding.h"
#include "plait/store.h"
#include "progress.h"
#include "read_back.h"
#include "rounding_report.h"

namespace plait {
namespace {

using PipelineOf = std::function<std::string(const AttributeSchema&)>;

struct ConvertArguments : CopyArguments {
  bool verify = false;
  std::set<std::string> derived, stored;  ///< ATTRIBUTE=derived and =stored among `compress`
  std::vector<std::string> max_errors;
  ErrorBounds bounds;  ///< of max_errors
};

struct Target {
  StoreOptions options;
  std::string backend_reason;
};

BackendChoice backend_of_copy(const ConvertArguments& arguments, const Store& source,
                              const BackendRegistry& backends) {
  if (!arguments.bounds.empty() && arguments.backend.empty() && arguments.compress.empty() &&
      !source.backend_traits().compressed)
    return {"compressed", "because of --max-error"};
  return choose_backend_of_copy(arguments, source, backends);
}

/// The pipelines of the copy, with the steps of the attributes that are rounded.
PipelineOf with_steps(const PipelineOf& pipeline_of, const ErrorBounds& bounds,
                      const Store& source) {
  std::map<std::string, double> steps;
  for (const auto& [name, bound] : bounds.all()) {
    const AttributeId id = source.attribute(name);
    steps[name] = Rounder(source.attributes()[id].schema, bound, source.base_bytes(id)).step();
  }
  return [=](const AttributeSchema& schema) {
    const std::string pipeline = pipeline_of(schema);
    const auto step = steps.find(schema.name);
    return step == steps.end() ? pipeline : pipeline_of_rounded(pipeline, step->second);
  };
}

Target target_of(const ConvertArguments& arguments, const Store& source,
                 const BackendRegistry& backends) {
  StoreOptions options = source.options();
  BackendChoice choice = backend_of_copy(arguments, source, backends);
  options.backend = choice.name;
  const BackendRegistry::Entry& backend =
      find_backend_of_copy(arguments, options.backend, "convert", backends);
  const bool stays_compressed = source.backend_traits().compressed && backend.traits.compressed;
  if (!stays_compressed) options.pipeline = backend.default_pipeline;
  if ((!arguments.compress.empty() && backend.traits.compressed) ||
      (!arguments.bounds.empty() && !stays_compressed && backend.traits.compressed))
    options.pipeline_of = pipelines_of(arguments.compress, source);
  else if (stays_compressed)
    options.pipeline_of = [&source](const AttributeSchema& schema) {
      return pipelines_of_levels(source, source.attribute(schema.name));
    };
  if (!arguments.bounds.empty() && options.pipeline_of)
    options.pipeline_of = with_steps(options.pipeline_of, arguments.bounds, source);
  PipelineOf stored = options.pipeline_of;
  if (!stored) stored = [pipeline = options.pipeline](const AttributeSchema&) { return pipeline; };
  options.pipeline_of = with_derived(source, arguments.derived, arguments.stored,
                                     arguments.compress, backends, std::move(stored));
  for (const AttributeInfo& info : source.attributes())
    if (const std::string pipeline = options.pipeline_of(info.schema); !is_derived(pipeline))
      backend.validate_pipeline(pipeline, info.schema);
  set_common_options(arguments, options);
  return {options, std::move(choice.reason)};
}

int run_convert(const ConvertArguments& arguments, const CommandContext& context) {
  Stopwatch clock;
  Store source = open_source(arguments, context);
  OpenOptions open;
  open.budget_bytes = arguments.memory_bytes / 2;
  const Target target = target_of(arguments, source, context.backends);
  const StoreOptions& options = target.options;
  PartialStore output(arguments.to, arguments.force ? Existing::kReplace : Existing::kRefuse);
  remove_left_overs_of(arguments.to, report_warning);

  const std::uint64_t from_bytes = source.stored_bytes();
  std::uint64_t to_bytes = 0;
  std::string word;
  std::map<std::string, Rounding> roundings;
  build_output(output, [&] {
    Store copy = Store::create(output.make(), source.base(), options, context.backends);
    {
      Progress progress("convert", ProgressUnit::kBytes);
      copy_levels(
          source, copy,
          [&](std::uint64_t done, std::uint64_t total) { return progress.update(done, total); },
          arguments.bounds);
    }
    for (const auto& [name, bound] : arguments.bounds.all())
      roundings[name] = *copy.rounding(copy.attribute(name));
    copy.commit();
    to_bytes = copy.stored_bytes();
    copy.close();
    if (arguments.verify)
      word = arguments.bounds.empty()
                 ? compare_copy(source, output.path(), open, arguments.threads, context.backends)
                 : compare_rounded_copy(source, output.path(), open, arguments.threads,
                                        context.backends, arguments.bounds);
  });
  throw_if_interrupted();
  output.publish(true, report_warning);

  const double ratio = static_cast<double>(from_bytes) / static_cast<double>(to_bytes);
  if (!context.json) {
    print(fmt::format("{}: {} by backend {} ({}), was {} by {} ({:.2f} to 1), {:.2f} s\n",
                      output.final_path().native(), format_bytes(to_bytes), options.backend,
                      target.backend_reason, format_bytes(from_bytes), source.options().backend,
                      ratio, clock.seconds()));
    for (const auto& [name, rounding] : roundings)
      print(fmt::format("{}: {}\n", name, to_text(rounding)));
    if (!word.empty())
      print(fmt::format("read back: digest {}, {}\n", word,
                        roundings.empty() ? "equal to that of the source"
                                          : "every record within its bound of the source"));
    return kExitDone;
  }
  nlohmann::ordered_json report = {
      {"from", arguments.from.string()},    {"store", output.final_path().string()},
      {"backend", options.backend},         {"backend_reason", target.backend_reason},
      {"block_bytes", options.block_bytes}, {"from_stored_bytes", from_bytes},
      {"stored_bytes", to_bytes},           {"ratio", ratio},
      {"seconds", clock.seconds()}};
  for (const auto& [name, rounding] : roundings) report["max_error"][name] = to_json(rounding);
  if (!word.empty()) report["digest"] = word;
  print(report.dump(2) + "\n");
  return kExitDone;
}

}  // namespace

void add_convert_command(CommandLine& program, CommandContext& context) {
  const auto arguments = std::make_shared<ConvertArguments>();
  CommandLine* command = program.add_subcommand(
      "convert", "Copy a store into another backend, compression or block size");
  add_copy_options(*command, context, *arguments, "Threads of --verify");
  add_max_error_option(*command, arguments->max_errors);
  command->add_flag("--verify", arguments->verify,
                    "Read the copy back from the disk and compare it with STORE");
  command->footer(
      backend_help(context.backends) + compression_help() +
      "\n"
      "The copy is like STORE in everything that no option changes.\n"
      "\n"
      "--compress normal=derived, with any backend, makes a copy without normals: reading\n"
      "computes them from the positions. The command compares them with those of STORE, and\n"
      "refuses if they differ. --compress normal=stored stores them again, as a pipeline does.\n"
      "\n" +
      max_error_help() +
      " --verify then compares\n"
      "every record with STORE. --max-error implies --compress default.\n"
      "\n"
      "Examples:\n"
      "  plait convert surface.plait small.plait --compress small\n"
      "  plait convert surface.plait mixed.plait --compress default --compress @5-=fast\n"
      "  plait convert surface.plait lossy.plait --max-error 1e-6rel --max-error normal=1e-3\n"
      "  plait convert surface.plait lean.plait --compress normal=derived\n"
      "  plait convert small.plait fast.plait --backend mmap --block 256KiB --verify");
  command->callback([arguments, &context] {
    context.run = [arguments, &context] {
      arguments->derived = take_derived(arguments->compress);
      arguments->stored = take_stored(arguments->compress);
      for (const std::string& text : arguments->max_errors) arguments->bounds.add(text);
      return run_convert(*arguments, context);
    };
  });
}

}  // namespace plait
