// tools/tune/choices.h: ways to store all attributes: a block size, and a pipeline for each.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tune/disk_model.h"
#include "tune/figures.h"

namespace plait::tune {

struct Choice {
  std::uint64_t block_bytes = 0;
  std::vector<std::size_t> trials;  ///< [attribute] in Trials::trials
  friend bool operator==(const Choice&, const Choice&) = default;
};

/// Whether all attributes are stored as they are, with the backend pread.
bool stores_raw(const Trials& trials, const Choice& choice);
/// Whether the choice itself was stored and read (Trials::corrections).
bool was_probed(const Trials& trials, const Choice& choice);

/// Which end of the intervals.
enum class Bound : std::uint8_t { kLow, kValue, kHigh };

/// What the attributes take with this choice. `without`: as rates_of(), for this attribute.
struct LeftOut {
  std::size_t attribute = 0, part = 0;
};
std::vector<Work> work_of(const Trials& trials, const Choice& choice, Bound bound = Bound::kValue,
                          std::optional<LeftOut> without = {});

/// The choices that may be best for something: for each block size, all combinations of pipelines
/// that no other pipeline of the same attribute beats in size, both rates, and in being free to
/// change in place. Combinations that others beat are left out too.
std::vector<Choice> worthwhile_choices(const Trials& trials);
/// The choice with `pipelines` [attribute]; nothing if one was not measured.
std::optional<Choice> choice_with(const Trials& trials, std::uint64_t block_bytes,
                                  const std::vector<std::string>& pipelines);
/// A preset of plait/backends/compression.h.
std::optional<Choice> preset_choice(const Trials& trials, std::uint64_t block_bytes,
                                    std::string_view preset);

/// The sizes of blocks in the trials, ascending.
std::vector<std::uint64_t> block_sizes(const Trials& trials);

/// "position: hierarchy+shuffle,zstd:1; normal: normals+shuffle,zstd:1; blocks of 1MiB". One
/// pipeline for all attributes is named once.
std::string to_text(const Trials& trials, const Choice& choice);
/// "1MiB", as the options of the program take it.
std::string size_argument(std::uint64_t bytes);

}  // namespace plait::tune
