// plait/options.h: options of a store. A value out of range is refused, never clamped.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "plait/backend.h"
#include "plait/budget.h"
#include "plait/namespace.h"

PLAIT_BEGIN_NAMESPACE

enum class Durability : std::uint8_t {
  kCommit,  ///< commit() returns when the version is on the disk
  kNone,    ///< for temporary stores: commit() publishes without waiting for the disk
};

/// How a store overwrites blocks of a committed version. This option is for backends that overwrite
/// in place. Other backends write the new bytes to free space of the same file, whatever this
/// option is.
enum class Overwriting : std::uint8_t {
  /// The level gets a new file, and the commit replaces the old file by the new one. If a pass
  /// overwrites a whole level, each byte is written once. If it overwrites a part of a level, the
  /// commit copies the rest. Until the commit, both files take disk space. Readers can have the
  /// store open at the same time.
  kNewGeneration,
  /// The block is overwritten in the level's file. The store first saves the old bytes to the
  /// journal (unless durability is kNone). This is for programs that change a few blocks of a large
  /// level. No reader can have the store open at the same time.
  kInPlace,
};

/// Options of Store::create().
struct StoreOptions {
  // Behaviour
  std::string backend = "pread";  ///< a name in the registry, or "name:key=value,..."
  /// How blocks are encoded: "shuffle,zstd:1", or more (plait/level_pipelines.h). Empty: the
  /// default of the backend. Store::set_pipeline gives an attribute a pipeline of its own.
  std::string pipeline = {};
  /// Gives each attribute that is added a pipeline; empty: `pipeline` for all of them.
  std::function<std::string(const AttributeSchema&)> pipeline_of = {};
  std::string layout = "given";  ///< the name of the order of `base`, which the store records
  int base_level = 0;            ///< how often the user's mesh was refined to make `base` (rebase)
  Durability durability = Durability::kCommit;
  Overwriting overwriting = Overwriting::kNewGeneration;

  // Performance
  std::uint64_t block_bytes = 1 << 20;  ///< unit of I/O; 4 KiB to 1 GiB, a power of two
  /// For frames and for scratch memory of the backend; at least 64 KiB.
  std::uint64_t budget_bytes = 256u << 20;
  /// The number of threads that prefetch blocks and write dirty ones, 0 to 64. With 0, each
  /// transfer runs in the thread that needs it. Not set: one thread, or one for each processor if
  /// the backend compresses.
  std::optional<int> io_threads = {};
  /// If it is set, `budget_bytes` are a part of it (plait/budget.h).
  std::shared_ptr<Budget> budget = {};
};

/// Options of Store::open().
struct OpenOptions {
  bool writable = false;
  std::uint64_t budget_bytes = 256u << 20;
  std::optional<int> io_threads = {};  ///< as in StoreOptions
  /// For writers. With kNone the store never waits for the disk, so a crash of the system may
  /// destroy the store.
  Durability durability = Durability::kCommit;
  Overwriting overwriting = Overwriting::kNewGeneration;
  std::shared_ptr<Budget> budget = {};  ///< as in StoreOptions
};

PLAIT_END_NAMESPACE
