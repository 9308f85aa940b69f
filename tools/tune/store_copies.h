// tools/tune/store_copies.h: copies of a store that are stored as a choice says, and how long
// reading them takes through the pager and the backend, cold.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <vector>

#include "plait/store.h"
#include "tune/choices.h"

namespace plait::tune {

/// Called now and then with the bytes that were copied since the last call. False cancels.
using CopyProgress = std::function<bool(std::uint64_t bytes)>;

/// The options of a copy of `source`: the backend pread if all attributes are stored as they are,
/// else compressed with the pipelines of the choice.
StoreOptions options_of_copy(const Store& source, const Trials& trials, const Choice& choice);

/// What a copy takes of the disk, and how long reading it takes.
struct CopyFigures {
  std::vector<double> stored_bytes;  ///< [attribute with levels] block tables included
  std::vector<double> read_seconds;  ///< [attribute with levels]
  bool is_cold = true;               ///< none of it was in memory
};
double sum_of(const std::vector<double>& values);

/// Makes a durable copy at `out`, of the levels up to `finest_level` only. Blocks of a scheme are
/// predicted as in a copy of all levels. Returns the stored bytes. Errors: those of Store::create,
/// of reading and of writing; kCancelled.
std::vector<double> copy_store(const Store& source, const Trials& trials, const Choice& choice,
                               int finest_level, const std::filesystem::path& out,
                               const BackendRegistry& backends, const CopyProgress& proceed);

/// Reads all levels of a store, each from front to back, as `plait export` and `plait convert` do,
/// after its files have left the page cache. Errors: those of Store::open and Session::pin.
CopyFigures read_cold(const std::filesystem::path& path, std::uint64_t budget_bytes,
                      const BackendRegistry& backends);

/// The levels of a store up to the finest one with which they are at most `most_bytes`, but at
/// least one level.
struct CoarseLevels {
  int finest_level = 0;
  std::uint64_t bytes = 0;  ///< of records
};
CoarseLevels coarse_levels(const Store& store, std::uint64_t most_bytes);
/// The bytes of records of an attribute's levels up to `finest_level`.
std::uint64_t level_bytes(const Store& store, AttributeId id, int finest_level);
/// The attributes that have levels, in the order of Trials::attributes.
std::vector<AttributeId> refined_attributes(const Store& store);

}  // namespace plait::tune
