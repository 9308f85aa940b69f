// plait/options.h: options of a store. A value out of range is refused, never clamped.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "plait/attribute.h"
#include "plait/detail/namespace.h"
#include "plait/extend/pipeline.h"
#include "plait/progress.h"

PLAIT_BEGIN_NAMESPACE

enum class Durability : std::uint8_t {
  kCommit,  ///< commit() returns when the version is on the disk
  kNone,    ///< for temporary stores: commit() publishes without waiting for the disk
};

/// The smallest budget of a store.
inline constexpr std::uint64_t kLeastBudgetBytes = 64u << 10;

/// The pipelines of each attribute.
using PipelinesOf = std::function<LevelPipelines(const AttributeSchema&)>;

/// Options of Store::create(): wishes. What a store is, it records (plait/extend/provenance.h).
struct StoreOptions {
  // Behaviour
  /// A name in the registry, or "auto": what BackendRegistry::choose()
  /// chooses. Store::options() of the new store has the chosen name.
  std::string backend = "auto";
  /// For "auto": the bytes that all levels will have, before compression. 0: not known, or few.
  std::uint64_t expected_bytes = 0;
  /// How blocks are encoded: "shuffle,zstd:1", or more (plait/extend/pipeline.h). Not set: the
  /// default of the backend. Store::set_pipeline gives an attribute a pipeline of its own.
  std::optional<LevelPipelines> pipeline = {};
  /// Gives each attribute that is added a pipeline; empty: `pipeline` for all of them.
  PipelinesOf pipeline_of = {};
  Durability durability = Durability::kCommit;

  /// Whether the store gets the file base.index, from which opening takes the base mesh instead of
  /// computing it again (about 66 bytes for each base face). Not set: for 16,384 base faces and
  /// more.
  std::optional<bool> base_index = {};

  // Performance
  /// Unit of I/O: 4 KiB to 1 GiB, a power of two. 0: 64 KiB, or 256 KiB with a backend that
  /// compresses. Store::options() of the new store has the chosen size.
  std::uint64_t block_bytes = 0;
  /// For frames and for scratch memory of the backend; at least kLeastBudgetBytes.
  std::uint64_t budget_bytes = 256u << 20;
  /// The number of threads that prefetch blocks and write dirty ones, 0 to 64. With 0, each
  /// transfer runs in the thread that needs it. Not set: one for each processor.
  std::optional<int> io_threads = {};
  StoreEvents events = {};  ///< whom the store tells what it does (plait/progress.h)
  /// If it is set, passes over this store compute on threads of the program: they call it with the
  /// count that their option `threads` gives, if that is more than one
  /// (plait/progress.h). Empty: passes start threads.
  ParallelFor parallel_for = {};
};

/// Options of Store::open(). Members that StoreOptions also has are in the same order.
struct OpenOptions {
  bool writable = false;
  /// For writers. With kNone the store never waits for the disk, so a crash of the system may
  /// destroy the store.
  Durability durability = Durability::kCommit;
  /// As in StoreOptions, for a store that does not have the file: the first commit adds it.
  std::optional<bool> base_index = {};
  std::uint64_t budget_bytes = 256u << 20;
  std::optional<int> io_threads = {};  ///< as in StoreOptions
  StoreEvents events = {};             ///< as in StoreOptions
  ParallelFor parallel_for = {};       ///< as in StoreOptions
};

PLAIT_END_NAMESPACE
