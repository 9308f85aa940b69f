#include "copy_arguments.h"

#include <fmt/format.h>

#include <system_error>

#include "plait/attribute_levels.h"
#include "plait/backends/choose_backend.h"
#include "plait/error.h"

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

BackendChoice choose_backend_of_copy(const CopyArguments& arguments, const Store& source,
                                     const BackendRegistry& backends) {
  if (arguments.backend == "auto") {
    std::uint64_t raw_bytes = 0;
    for (AttributeId id = 0; id < source.attributes().size(); ++id)
      raw_bytes += bytes_of_levels(source, id);
    return choose_backend(backends, arguments.to, raw_bytes);
  }
  if (!arguments.backend.empty()) return {arguments.backend, "given by the user"};
  if (!arguments.compress.empty()) return {"compressed", "because of --compress"};
  return {source.options().backend, "the same as the source"};
}

const BackendRegistry::Entry& find_backend_of_copy(const CopyArguments& arguments,
                                                   const std::string& backend, const char* command,
                                                   const BackendRegistry& backends) {
  const BackendRegistry::Entry& found = backends.find(backend);
  const auto refuse = [&](const std::string& reason) {
    return Error(ErrorCode::kInvalidArgument, fmt::format("{}{}", command, reason));
  };
  if (!found.traits.durable) throw refuse(fmt::format(": backend {} writes no files", found.name));
  if (!found.traits.compressed && !arguments.compress.empty())
    throw refuse(
        fmt::format(": --compress needs a backend that compresses, and {} does not: add "
                    "--backend compressed",
                    found.name));
  found.validate(BackendRegistry::options_in(backend));
  std::error_code ignored;
  if (std::filesystem::equivalent(arguments.from, arguments.to, ignored))
    throw refuse(fmt::format(" {}: source and copy are the same", arguments.from.native()));
  return found;
}

void set_common_options(const CopyArguments& arguments, StoreOptions& options) {
  if (arguments.block_bytes != 0) options.block_bytes = arguments.block_bytes;
  options.budget_bytes = arguments.memory_bytes / 2;
  options.durability = Durability::kCommit;
}

}  // namespace plait
