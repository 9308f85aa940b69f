// bench/tune/choice.h: a way to store a surface: the value that the table, the sentence and the
// command are made of.
#pragma once

#include <string>
#include <vector>

#include "plait/compression.h"
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
/// Each attribute of `names` with its own pipeline.
Choice choice_of_pipelines(const std::vector<std::string>& names,
                           const std::vector<Pipeline>& pipelines);
/// The options of a copy of `source` that is stored so.
StoreOptions options_of_copy(const Store& source, const Choice& choice);
/// What the choice does with these records.
Pipeline pipeline_of(const Choice& choice, const AttributeSchema& schema);

/// Whether both do the same with the blocks of these attributes, whatever their names are.
bool store_alike(const Choice& a, const Choice& b, const std::vector<AttributeSchema>& attributes);

/// Whether a pipeline cannot store the records, and not another fault.
bool is_refusal(const Error& error) noexcept;

/// The attributes that have levels.
std::vector<AttributeId> refined_attributes(const Store& store);
/// The bytes of an attribute's records, up to a level.
std::uint64_t level_bytes(const Store& store, AttributeId id, int finest_level);
/// Of all attributes and levels.
std::uint64_t raw_bytes(const Store& store);

}  // namespace plait::tune
