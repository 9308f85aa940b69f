// bench/tune/copy.h: a choice is a way to store a surface: the value that the table, the sentence
// and the command are made of. A copy is stored as a choice says and read, for real.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "plait/compression.h"
#include "plait/error.h"
#include "plait/extend/backend_registry.h"
#include "plait/extend/pipeline_registry.h"
#include "plait/store.h"

namespace plait::tune {

struct Choice {
  /// "small", "fast, normal made again", or the pipelines.
  std::string name;
  /// The values of --compress; empty: blocks as they are.
  std::vector<std::string> compress;
  bool is_preset = false;
  std::uint64_t block_bytes = 0;  ///< 0: as in the source
  std::string backend = "compressed";

  /// "--compress small", or "--backend pread"; and --block, if that is not as in the source.
  std::string options() const;
  friend bool operator==(const Choice&, const Choice&) = default;
};

Compression compression_of(const Choice& choice);
/// The preset `none` keeps blocks as they are, with `raw_backend`.
Choice choice_of_preset(const std::string& preset, const std::string& raw_backend);
/// Each attribute with its own pipeline.
Choice choice_of_pipelines(const std::vector<AttributeSchema>& attributes,
                           const std::vector<Pipeline>& pipelines);
/// What the choice does with these records.
Pipeline pipeline_of(const Choice& choice, const AttributeSchema& schema);

/// Whether both do the same with the blocks of these attributes, whatever their names are.
bool store_alike(const Choice& a, const Choice& b, const std::vector<AttributeSchema>& attributes);

/// Whether a pipeline cannot store the records, and not another fault.
bool is_refusal(const Error& error) noexcept;

/// False cancels.
using Proceed = std::function<bool()>;

/// What a copy took, or one attribute of it.
struct CopyFigures {
  double stored_bytes = 0;   ///< of the copy: as `plait convert` and `plait info` count them
  double write_seconds = 0;  ///< of an attribute: to the page cache; of the copy: to the disk
  double read_seconds = 0;   ///< of a sweep over all levels, out of the page cache
  double warm_seconds = 0;   ///< the same from the page cache: what is not the disk
  std::uint64_t blocks = 0, made_blocks = 0;  ///< of an attribute; the latter take no bytes
};

/// A copy as a whole. Reading the source is in `write_seconds`.
struct CopyRun : CopyFigures {
  bool is_cold = true;     ///< false on a file system in memory
  bool can_change = true;  ///< records can be changed in place: no block is coded from another
  std::vector<CopyFigures> parts = {};  ///< [attribute of refined_attributes()]
};

enum class Reads : std::uint8_t {
  kCold,      ///< repeated until they took 0.3 s; then once from the page cache
  kWarmOnly,  ///< and nothing waits for the disk: for a sample
};

/// The attributes that have levels.
std::vector<AttributeId> refined_attributes(const Store& store);
/// The bytes of the records of all levels.
std::uint64_t raw_bytes(const Store& store);

/// Makes a copy at `path`, commits it, reads it, and removes it. Errors: those of Store::create, of
/// coding, reading and writing; kCancelled.
CopyRun store_and_read(Store& source, const Choice& choice, const std::filesystem::path& path,
                       Reads reads, const BackendRegistry& backends, const Proceed& proceed);

/// The levels of `source`, in memory, up to the finest one with which they are at most
/// `most_bytes`, but at least one level. Errors: those of reading.
Store coarse_levels_in_memory(const Store& source, std::uint64_t most_bytes,
                              const BackendRegistry& backends);

}  // namespace plait::tune
