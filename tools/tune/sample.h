// tools/tune/sample.h: chooses the parts of a store that pipelines are tried on.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "plait/store.h"
#include "tune/store_bytes.h"

namespace plait::tune {

/// A whole block of the largest size that is tried. Blocks of the smaller sizes divide it.
struct SamplePart {
  AttributeId attribute = 0;
  int level = 0;
  std::uint64_t offset = 0, bytes = 0;  ///< in the level
  double compressibility = 0;           ///< byte_entropy()
};

struct Sample {
  std::uint64_t seed = 0;
  std::vector<std::vector<SamplePart>> parts;  ///< [attribute]; none if it has no levels
  std::vector<bool> is_whole;                  ///< [attribute] the parts are all of it
};

/// Chooses up to `most_parts` blocks of each attribute. All levels together, the chance of a block
/// is its share of the bytes. Of twice as many blocks, read in full and sorted by byte_entropy(),
/// every other one is taken, so easy and hard blocks are in the sample as in the store. The parts
/// come in an order of no pattern, so any number of the first ones is a sample too. The same seed
/// gives the same sample. `proceed`: false ends the call early, with the parts found so far.
/// Errors: those of reading blocks. Pinned by tests/tools/tune/sample_test.cpp.
Sample take_sample(StoreBytes& bytes, const BlockGrid& grid, std::size_t most_parts,
                   std::uint64_t seed, const std::function<bool()>& proceed);

/// The entropy of the bytes of the differences between records, in bits a byte, 0 to 8: a cheap
/// guess of how well a block compresses. `stride`: bytes of a record.
double byte_entropy(std::span<const std::byte> raw, std::size_t stride);

}  // namespace plait::tune
