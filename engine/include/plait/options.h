// plait/options.h: options of a store. A value out of range is refused, never clamped.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "plait/backend.h"

namespace plait {

enum class Durability : std::uint8_t {
  kCommit,  ///< commit() returns when the version is on the disk
  kNone,    ///< scratch: commit() publishes without waiting for the disk
};

struct StoreOptions {
  // Behaviour
  std::string backend = "pread";        ///< a name in the registry
  BackendOptions backend_options = {};  ///< codec and filter
  std::string layout = "given";         ///< recorded in the manifest: the order of `base`
  std::string scheme = {};  ///< recorded: what made the levels ("loop", ...); may be empty
  int base_level = 0;       ///< how often `base` was refined already (rebase)
  Durability durability = Durability::kCommit;

  // Performance
  std::uint64_t block_bytes = 1 << 20;      ///< unit of I/O; 4 KiB to 1 GiB, a power of two
  std::uint64_t budget_bytes = 256u << 20;  ///< all frames; at least 64 KiB
  /// Threads that read ahead and write behind, 0 to 64; 0: every transfer happens in the caller.
  /// Not set: one, and where blocks are compressed one for each processor.
  std::optional<int> io_threads = {};
};

struct OpenOptions {
  bool writable = false;
  std::uint64_t budget_bytes = 256u << 20;
  std::optional<int> io_threads = {};  ///< as in StoreOptions
  /// Of what a writer does. kNone: blocks are overwritten without a way back, so that a crash may
  /// cost the store.
  Durability durability = Durability::kCommit;
};

}  // namespace plait
