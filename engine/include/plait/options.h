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

/// What happens to blocks of a committed version that are written anew, in a backend that
/// overwrites in place. Others write elsewhere in the same file, whatever is chosen here.
enum class Overwriting : std::uint8_t {
  /// The level gets a new file beside the old one, and the commit switches. Each byte of a pass
  /// that overwrites a level whole is written once; of a level that is overwritten in part the
  /// commit copies the rest. Takes the disk space of the level once more. Readers and the writer do
  /// not disturb each other.
  kNewGeneration,
  /// In place; what the blocks held goes to the rollback journal first (unless durability is
  /// kNone). For a few blocks of a large level. Nobody can read the store meanwhile.
  kInPlace,
};

struct StoreOptions {
  // Behaviour
  std::string backend = "pread";  ///< a name in the registry, or "name:key=value,..."
  /// How blocks are encoded: stages in their order, such as "shuffle,zstd:1". Empty: as the backend
  /// does by default. Attributes may have pipelines of their own (Store::set_pipeline).
  std::string pipeline = {};
  std::string layout = "given";  ///< recorded in the store: the order of `base`
  int base_level = 0;            ///< how often `base` was refined already (rebase)
  Durability durability = Durability::kCommit;
  Overwriting overwriting = Overwriting::kNewGeneration;

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
  /// Of what a writer does. kNone: nothing waits for the disk, so that a crash may cost the store.
  Durability durability = Durability::kCommit;
  Overwriting overwriting = Overwriting::kNewGeneration;
};

}  // namespace plait
