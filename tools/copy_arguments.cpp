#include "copy_arguments.h"

#include "arguments.h"

namespace plait {

void add_copy_options(CommandLine& command, CommandContext& context, CopyArguments& arguments,
                      const std::string& threads_description) {
  command.add_option("STORE", arguments.from, "The store to copy")->required();
  add_output_option(command, "OUT", arguments.to, "The store to make")->required();
  command
      .add_option("--backend", arguments.backend,
                  "The backend of the copy (see below); auto: chosen by its size")
      ->default_str("as in STORE");
  add_compress_option(command, arguments.compress);
  add_size_option(command, "--block", arguments.block_bytes, "Unit of I/O, a power of two")
      ->default_str("as in STORE");
  add_size_option(command, "--memory", arguments.memory_bytes,
                  "Budget for blocks in memory, half of it for each store");
  add_threads_option(command, arguments.threads, threads_description);
  command.add_flag("--force", arguments.force,
                   "Replace OUT if it is a store, when the new store is complete");
  add_plugin_option(command, context);
  add_json_option(command, context);
}

Store open_source(const CopyArguments& arguments, const CommandContext& context) {
  OpenOptions open;
  open.budget_bytes = arguments.memory_bytes / 2;
  return Store::open(arguments.from, open, context.open_backends);
}

CopyChoices choices_of(const CopyArguments& arguments) {
  return {arguments.from,        arguments.to,
          arguments.backend,     !arguments.compress.empty(),
          arguments.block_bytes, arguments.memory_bytes};
}

}  // namespace plait

namespace plait {

Compression compression_of(const std::vector<std::string>& texts) {
  Compression compression;
  for (const std::string& text : texts) compression.add(text);
  return compression;
}

PipelinesOf pipelines_of(const std::vector<std::string>& texts, const Store& store) {
  compression_of(texts).check_levels(store.base_level(), store.finest_level());
  return pipelines_of(texts);
}

std::string max_error_help() {
  return "--max-error 1e-5 rounds positions so that no coordinate changes by more than 1e-5, and\n"
         "1e-6rel by more than a millionth of the diagonal of the base vertices' box. With\n"
         ",euclidean, no vertex moves farther. normal=1e-3 rounds normals. Base vertices, and\n"
         "what has no bound, stay exact; plait info prints the errors.";
}

}  // namespace plait
