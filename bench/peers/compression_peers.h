// bench/peers/compression_peers.h: other libraries that compress numbers without loss, as far as
// they are installed.
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace plait::bench {

/// A block of a level: `rows` rows of `columns` records of three float32.
struct PeerBlock {
  std::span<const std::byte> raw;
  std::size_t columns, rows;
};

struct CompressionPeer {
  std::string name;
  /// Returns the encoded bytes; empty on failure.
  std::function<std::vector<std::byte>(const PeerBlock&)> encode;
  /// Fills `raw`; false on failure.
  std::function<bool(std::span<const std::byte> encoded, const PeerBlock& shape,
                     std::span<std::byte> raw)>
      decode;
};

std::vector<CompressionPeer> compression_peers();

}  // namespace plait::bench
