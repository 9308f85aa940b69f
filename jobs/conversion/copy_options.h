// conversion/copy_options.h: which backend and which options the copy of a store gets. Jobs and
// commands that copy a store share it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "plait/detail/namespace.h"
#include "plait/extend/backend_registry.h"
#include "plait/store.h"

PLAIT_BEGIN_NAMESPACE

/// What the user has chosen for a copy.
struct CopyChoices {
  std::filesystem::path from, to;
  std::string backend = {};        ///< empty: the same as the source
  bool compresses = false;         ///< the user has chosen a compression
  std::uint64_t block_bytes = 0;   ///< 0: the same as the source
  std::uint64_t budget_bytes = 0;  ///< of both stores
};

/// What the copy's backend is called, and why.
BackendChoice choose_backend_of_copy(const CopyChoices& choices, const Store& source,
                                     const BackendRegistry& backends);
/// The backend of that name. Errors: those of BackendRegistry::find; kInvalidArgument if it writes
/// no files, or if it does not compress and the user has chosen a compression, and if source and
/// copy are the same. `verb` begins messages.
const RegisteredBackend& find_backend_of_copy(const CopyChoices& choices,
                                              const std::string& backend, const char* verb,
                                              const BackendRegistry& backends);
/// Sets the block size, the budget and the durability of the copy. `traits` are those of its
/// backend.
void set_common_options(const CopyChoices& choices, const Store& source,
                        const BackendTraits& traits, StoreOptions& options);

PLAIT_END_NAMESPACE
