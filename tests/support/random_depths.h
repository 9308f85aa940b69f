// Depths of faces for tests: runs of equal ones, as neighbours in a layout have them, or none.
#pragma once

#include <cstdint>
#include <random>
#include <vector>

namespace plait::test {

inline std::vector<std::uint8_t> random_depths(std::uint64_t faces, std::mt19937& random,
                                               int most) {
  std::vector<std::uint8_t> depths(faces);
  const auto change_percent = random() % 100;
  std::uint8_t depth = 0;
  for (std::uint8_t& of_face : depths) {
    if (random() % 100 < change_percent)
      depth = static_cast<std::uint8_t>(random() % (static_cast<unsigned>(most) + 1));
    of_face = depth;
  }
  return depths;
}

}  // namespace plait::test
