// bench/peers/coders.h: what encodes the blocks of a level: pipelines of plait, and other
// libraries, as far as they are installed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "peers/surfaces.h"
#include "plait/extend/pipeline.h"

namespace plait::bench {

/// `rows` rows of `columns` records of three float32.
struct RawBlock {
  std::uint64_t number;  ///< in its level
  std::span<const std::byte> raw;
  std::size_t columns, rows;
};

/// For one thread.
struct Coder {
  std::string name;
  /// Returns the size of what it wrote to the front of `to`, which has most_encoded(raw.size())
  /// bytes; 0 on failure.
  std::function<std::size_t(const RawBlock&, std::span<std::byte> to)> encode;
  /// Fills `raw`; false on failure. `encoded` is the front of what encode() wrote to, and the block
  /// is the same; its raw bytes are not read.
  std::function<bool(std::span<const std::byte> encoded, const RawBlock&, std::span<std::byte> raw)>
      decode;
};

/// Enough for the bounds of all coders, and for zfp, which fills up rows shorter than four.
constexpr std::size_t most_encoded(std::size_t raw_bytes) { return 8 * raw_bytes + 65536; }

/// The codec `none` stands for the filters alone. Refers to `surface`. Errors: as
/// PipelineRegistry::open.
Coder pipeline_coder(const RawSurface& surface, std::uint32_t attribute, const Pipeline& pipeline);

/// Those that lose nothing.
std::vector<Coder> peer_coders();

#if defined(PLAIT_BENCH_ZFP)
/// A 2-D stream for each component. `tolerance`: of a number; 0 to lose nothing.
Coder zfp(double tolerance);
#endif

}  // namespace plait::bench
