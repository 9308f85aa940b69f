// bench/tune/copy.h: stores a surface as a choice says and reads it, for real.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <vector>

#include "plait/extend/pipeline_registry.h"
#include "plait/store.h"
#include "tune/choice.h"

namespace plait::tune {

/// False cancels.
using Proceed = std::function<bool()>;

/// What one attribute took of a copy: written to the page cache, read from the disk, and read from
/// the page cache.
struct PartOfCopy {
  double stored_bytes = 0, write_seconds = 0, read_seconds = 0, warm_seconds = 0;
  std::uint64_t blocks = 0, made_blocks = 0;  ///< the latter take no bytes
};

struct CopyRun {
  double stored_bytes = 0;   ///< as `plait convert` and `plait info` count them
  double write_seconds = 0;  ///< until it is on the disk; reading the source is in it
  double read_seconds = 0;   ///< of a sweep over all levels, out of the page cache
  double warm_seconds = 0;   ///< the same from the page cache: what is not the disk
  bool is_cold = true;       ///< false on a file system in memory
  bool can_change = true;    ///< records can be changed in place: no block is coded from another
  std::vector<PartOfCopy> parts = {};  ///< [attribute of refined_attributes()]
};

enum class Reads : std::uint8_t {
  kCold,      ///< repeated until they took 0.3 s; then once from the page cache
  kWarmOnly,  ///< and nothing waits for the disk: for a sample
};

/// Makes a copy at `path`, commits it, reads it, and removes it. Errors: those of Store::create, of
/// coding, reading and writing; kCancelled.
CopyRun store_and_read(Store& source, const Choice& choice, const std::filesystem::path& path,
                       Reads reads, const BackendRegistry& backends, const Proceed& proceed);

/// The levels of `source`, in memory, up to the finest one with which they are at most
/// `most_bytes`, but at least one level. Errors: those of reading.
Store coarse_levels_in_memory(const Store& source, std::uint64_t most_bytes,
                              const BackendRegistry& backends);

}  // namespace plait::tune
