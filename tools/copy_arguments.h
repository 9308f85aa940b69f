// tools/copy_arguments.h: options of displace, which copies a store.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "arguments.h"
#include "command.h"
#include "conversion/copy_options.h"
#include "plait/compression.h"
#include "plait/extend/backend_registry.h"
#include "plait/options.h"
#include "plait/store.h"

namespace plait {

struct CopyArguments {
  std::filesystem::path from, to;
  std::string backend;                ///< empty: the same as the source
  std::vector<std::string> compress;  ///< empty: the same as the source
  std::uint64_t block_bytes = 0;      ///< 0: the same as the source
  /// The two stores share this budget.
  std::uint64_t memory_bytes = StoreOptions().budget_bytes;
  int threads = default_thread_count();
  bool force = false;
};

/// Adds STORE, OUT, --backend, --compress, --block, --memory, --threads, --force, --plugin and
/// --json. `arguments` must outlive parsing.
void add_copy_options(CommandLine& command, CommandContext& context, CopyArguments& arguments,
                      const std::string& threads_description);

/// Opens the source for reading.
Store open_source(const CopyArguments& arguments, const CommandContext& context);

/// The choices for the copy.
CopyChoices choices_of(const CopyArguments& arguments);

}  // namespace plait

// What --compress and --max-error mean for the commands that make a
// store.

namespace plait {

/// What the texts of --compress choose. Errors: as Compression::add().
Compression compression_of(const std::vector<std::string>& texts);
/// The pipelines that they choose for a store with the levels of `store`. Errors: also as
/// Compression::check_levels().
PipelinesOf pipelines_of(const std::vector<std::string>& texts, const Store& store);
/// The text about --max-error for --help.
std::string max_error_help();

}  // namespace plait
