#include "tune/sample.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <utility>

namespace plait::tune {
namespace {

/// A number of [0, 1), the same on every machine.
double uniform(std::mt19937_64& random) { return static_cast<double>(random() >> 11) * 0x1p-53; }

std::uint64_t whole_below(std::mt19937_64& random, std::uint64_t end) {
  return std::min(end - 1, static_cast<std::uint64_t>(uniform(random) * static_cast<double>(end)));
}

std::vector<SamplePart> all_blocks(const Store& store, const BlockGrid& grid,
                                   AttributeId attribute) {
  std::vector<SamplePart> parts;
  for (int level = store.base_level() + 1; level <= store.attributes()[attribute].finest_level;
       ++level) {
    const LevelGeometry& geometry = grid.geometry(attribute, level);
    for (std::uint64_t block = 0; block < geometry.block_count(); ++block)
      parts.push_back(
          {attribute, level, geometry.block_offset(block), geometry.block_bytes(block)});
  }
  return parts;
}

/// `count` places at the same distance, as bytes of all blocks one after another, from a random
/// first one on. Each block at most once.
std::vector<SamplePart> blocks_by_bytes(const std::vector<SamplePart>& blocks, std::size_t count,
                                        std::mt19937_64& random) {
  double all = 0;
  for (const SamplePart& part : blocks) all += static_cast<double>(part.bytes);
  const double distance = all / static_cast<double>(count);
  double next = uniform(random) * distance, end = 0;
  std::vector<SamplePart> chosen;
  for (const SamplePart& part : blocks) {
    end += static_cast<double>(part.bytes);
    if (next >= end) continue;
    chosen.push_back(part);
    while (next < end) next += distance;
  }
  return chosen;
}

/// Every other block in the order of compressibility, from a random first one on.
std::vector<SamplePart> every_other(std::vector<SamplePart> parts, std::size_t most,
                                    std::mt19937_64& random) {
  std::ranges::stable_sort(parts, {}, &SamplePart::compressibility);
  std::vector<SamplePart> chosen;
  const double step = static_cast<double>(parts.size()) / static_cast<double>(most);
  for (double at = uniform(random) * step; at < static_cast<double>(parts.size()); at += step)
    chosen.push_back(parts[static_cast<std::size_t>(at)]);
  return chosen;
}

}  // namespace

double byte_entropy(std::span<const std::byte> raw, std::size_t stride) {
  if (raw.size() <= stride) return 0;
  std::array<std::uint64_t, 256> counts{};
  for (std::size_t i = stride; i < raw.size(); ++i)
    ++counts[(std::to_integer<unsigned>(raw[i]) - std::to_integer<unsigned>(raw[i - stride])) &
             0xffu];
  const auto all = static_cast<double>(raw.size() - stride);
  double bits = 0;
  for (const std::uint64_t count : counts)
    if (count > 0) bits -= static_cast<double>(count) * std::log2(static_cast<double>(count) / all);
  return bits / all;
}

Sample take_sample(StoreBytes& bytes, const BlockGrid& grid, std::size_t most_parts,
                   std::uint64_t seed, const std::function<bool()>& proceed) {
  const Store& store = bytes.store();
  Sample sample;
  sample.seed = seed;
  std::mt19937_64 random(seed);
  for (AttributeId id = 0; id < store.attributes().size(); ++id) {
    std::vector<SamplePart> blocks = all_blocks(store, grid, id);
    const std::size_t count = blocks.size();
    std::vector<SamplePart> parts;
    if (count > most_parts) {
      for (SamplePart& part : blocks_by_bytes(blocks, 2 * most_parts, random)) {
        if (!proceed()) break;
        bytes.make_room();
        part.compressibility = byte_entropy(bytes.read(id, part.level, part.offset, part.bytes),
                                            store.attributes()[id].schema.record_bytes());
        parts.push_back(part);
      }
      if (parts.size() > most_parts) parts = every_other(std::move(parts), most_parts, random);
    } else {
      parts = std::move(blocks);
    }
    for (std::size_t i = parts.size(); i > 1; --i)
      std::swap(parts[i - 1], parts[whole_below(random, i)]);
    sample.is_whole.push_back(parts.size() == count);
    sample.parts.push_back(std::move(parts));
  }
  return sample;
}

}  // namespace plait::tune
