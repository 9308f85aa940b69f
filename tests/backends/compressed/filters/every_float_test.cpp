// All 2^32 floats have residuals that give them back.
#include <bit>
#include <catch2/catch.hpp>
#include <cstdint>
#include <limits>

#include "compressed/filters/residuals.h"

namespace plait::test {

TEST_CASE("Residuals_OfEveryFloat_GiveItBack") {
  std::uint64_t wrong = 0;
  for (const float prediction : {0.0f, -1.5f, std::numeric_limits<float>::infinity()}) {
    std::uint32_t bits = 0;
    do {
      const auto number = std::bit_cast<float>(bits);
      const std::uint32_t back =
          std::bit_cast<std::uint32_t>(from_residual(residual(number, prediction), prediction));
      wrong += back != bits;
    } while (++bits != 0);
  }
  CHECK(wrong == 0);
}

}  // namespace plait::test
