// plait convert: copies a store into another backend, compression or block size.

#include <fmt/format.h>

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "arguments.h"
#include "command.h"
#include "console.h"
#include "interrupt.h"
#include "measure.h"
#include "plait/backends/choose_backend.h"
#include "plait/backends/compression.h"
#include "plait/byte_text.h"
#include "plait/copy_levels.h"
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

struct Arguments {
  std::filesystem::path from, to;
  std::string backend;                ///< empty: the same as the source
  std::vector<std::string> compress;  ///< empty: the same as the source
  std::uint64_t block_bytes = 0;      ///< 0: the same as the source
  std::uint64_t memory_bytes = StoreOptions().budget_bytes;
  int threads = default_thread_count();
  bool verify = false, force = false;
  std::vector<std::string> max_errors;
  ErrorBounds bounds;  ///< of max_errors
};

struct Target {
  StoreOptions options;
  std::string backend_reason;
};

/// The raw bytes of all levels of all attributes.
std::uint64_t raw_bytes(const Store& store) {
  std::uint64_t bytes = 0;
  for (AttributeId id = 0; id < store.attributes().size(); ++id)
    for (int level = store.base_level() + 1; level <= store.attributes()[id].finest_level; ++level)
      bytes += store.level_file(id, level).geometry.total_bytes();
  return bytes;
}

BackendChoice backend_of_copy(const Arguments& arguments, const Store& source,
                              const BackendRegistry& backends) {
  if (!arguments.compress.empty() && arguments.backend.empty())
    return {"compressed", "because of --compress"};
  if (!arguments.bounds.empty() && arguments.backend.empty() && !source.backend_traits().compressed)
    return {"compressed", "because of --max-error"};
  if (arguments.backend == "auto") return choose_backend(backends, arguments.to, raw_bytes(source));
  if (!arguments.backend.empty()) return {arguments.backend, "given by the user"};
  return {source.options().backend, "the same as the source"};
}

/// The pipelines of the copy, with the steps of the attributes that are rounded.
PipelineOf with_steps(PipelineOf pipeline_of, const ErrorBounds& bounds, const Store& source) {
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

Target target_of(const Arguments& arguments, const Store& source, const BackendRegistry& backends) {
  StoreOptions options = source.options();
  BackendChoice choice = backend_of_copy(arguments, source, backends);
  options.backend = choice.name;
  const BackendRegistry::Entry& backend = backends.find(options.backend);
  if (!backend.traits.durable)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("convert: backend {} writes no files", backend.name));
  if (!backend.traits.compressed && !arguments.compress.empty())
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("convert: --compress needs a backend that compresses, and {} does not: "
                            "add --backend compressed",
                            backend.name));
  const bool stays_compressed = source.backend_traits().compressed && backend.traits.compressed;
  if (!stays_compressed) options.pipeline = backend.default_pipeline;
  if (!arguments.compress.empty() ||
      (!arguments.bounds.empty() && !stays_compressed && backend.traits.compressed))
    options.pipeline_of = pipelines_of(arguments.compress);
  else if (stays_compressed)
    options.pipeline_of = [&source](const AttributeSchema& schema) {
      const AttributeId id = source.attribute(schema.name);
      const int finest = source.attributes()[id].finest_level;
      return finest > source.base_level() ? source.level_file(id, finest).pipeline
                                          : source.options().pipeline;
    };
  if (!arguments.bounds.empty() && options.pipeline_of)
    options.pipeline_of = with_steps(options.pipeline_of, arguments.bounds, source);
  backend.validate(BackendRegistry::options_in(options.backend));
  for (const AttributeInfo& info : source.attributes())
    backend.validate_pipeline(
        options.pipeline_of ? options.pipeline_of(info.schema) : options.pipeline, info.schema);
  if (arguments.block_bytes != 0) options.block_bytes = arguments.block_bytes;
  options.budget_bytes = arguments.memory_bytes / 2;
  options.durability = Durability::kCommit;
  return {options, std::move(choice.reason)};
}

int run(const Arguments& arguments, const CommandContext& context) {
  Stopwatch clock;
  OpenOptions open;
  // The two stores share the budget of --memory.
  open.budget_bytes = arguments.memory_bytes / 2;
  Store source = Store::open(arguments.from, open, context.open_backends);
  const Target target = target_of(arguments, source, context.backends);
  const StoreOptions& options = target.options;
  std::error_code ignored;
  if (std::filesystem::equivalent(arguments.from, arguments.to, ignored))
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("convert {}: source and copy are the same", arguments.from.native()));
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
  const auto arguments = std::make_shared<Arguments>();
  CommandLine* command = program.add_subcommand(
      "convert", "Copy a store into another backend, compression or block size");
  command->add_option("STORE", arguments->from, "The store to copy")->required();
  add_output_option(*command, "OUT", arguments->to, "The store to make")->required();
  command->add_option("--backend", arguments->backend,
                      "The backend of the copy (see below); auto: chosen by its size");
  add_compress_option(*command, arguments->compress);
  add_max_error_option(*command, arguments->max_errors);
  add_size_option(*command, "--block", arguments->block_bytes, "Unit of I/O, a power of two")
      ->default_str("as in STORE");
  add_size_option(*command, "--memory", arguments->memory_bytes,
                  "Budget for blocks in memory, half of it for each store");
  add_threads_option(*command, arguments->threads, "Threads of --verify");
  command->add_flag("--verify", arguments->verify,
                    "Read the copy back from the disk and compare it with STORE");
  command->add_flag("--force", arguments->force,
                    "Replace OUT if it is a store, when the new store is complete");
  add_plugin_option(*command, context);
  add_json_option(*command, context);
  command->footer(
      backend_help(context.backends) + compression_help() +
      "\n"
      "The copy is like STORE in everything that no option changes.\n"
      "\n"
      "--max-error 1e-5 rounds positions so that no coordinate changes by more than 1e-5, and\n"
      "1e-6rel by more than a millionth of the diagonal of the base vertices' box. With\n"
      ",euclidean, no vertex moves farther. normal=1e-3 rounds normals. Base vertices, and\n"
      "what has no bound, stay exact; plait info prints the errors. --verify then compares\n"
      "every record with STORE. --max-error implies --compress default.\n"
      "\n"
      "Examples:\n"
      "  plait convert surface.plait small.plait --compress small\n"
      "  plait convert surface.plait lossy.plait --max-error 1e-6rel --max-error normal=1e-3\n"
      "  plait convert small.plait fast.plait --backend mmap --block 256KiB --verify");
  command->callback([arguments, &context] {
    context.run = [arguments, &context] {
      for (const std::string& text : arguments->max_errors) arguments->bounds.add(text);
      return run(*arguments, context);
    };
  });
}

}  // namespace plait
