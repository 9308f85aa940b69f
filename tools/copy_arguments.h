// tools/copy_arguments.h: options of the commands that copy a store: convert and displace.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "arguments.h"
#include "command.h"
#include "plait/backend.h"
#include "plait/backend_choice.h"
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

/// What the copy's backend is called, and why.
BackendChoice choose_backend_of_copy(const CopyArguments& arguments, const Store& source,
                                     const BackendRegistry& backends);
/// The backend of that name. Errors: those of BackendRegistry::find; kInvalidArgument if it writes
/// no files, or if it does not compress and --compress is given, and if source and copy are the
/// same.
const BackendRegistry::Entry& find_backend_of_copy(const CopyArguments& arguments,
                                                   const std::string& backend, const char* command,
                                                   const BackendRegistry& backends);

/// Sets the block size, the budget and the durability of the copy.
void set_common_options(const CopyArguments& arguments, StoreOptions& options);

}  // namespace plait
