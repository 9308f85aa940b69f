// bench/peers/lossy_peers.h: other libraries that store positions with a bounded error, as far as
// they are installed.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace plait::bench {

struct LossyMesh {
  std::vector<float> numbers;  ///< x, y, z of each vertex
  std::vector<std::array<std::uint32_t, 3>> triangles;
  /// The slots of one level: square grids, one after another.
  struct Grids {
    std::size_t first, side, count;  ///< the first vertex; vertices in a row; grids
  };
  std::vector<Grids> grids;
};

struct LossySize {
  std::size_t bytes = 0;
  double largest_error = 0;  ///< of a coordinate
};

struct LossyPeer {
  std::string name;
  /// The smallest result whose largest measured error is at most `bound`; nothing if there is none.
  std::function<std::optional<LossySize>(const LossyMesh& mesh, double bound)> size;
};

std::vector<LossyPeer> lossy_peers();

inline double largest_error(const std::vector<float>& a, const std::vector<float>& b) {
  double largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    largest = std::max(largest, std::abs(double{a[i]} - double{b[i]}));
  return largest;
}

}  // namespace plait::bench
