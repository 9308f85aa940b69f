// Numbers as integers of the same order: a bijection of all bit patterns.
#include "compressed/filters/ordered_words.h"

#include <bit>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <limits>

#include "support/words.h"

namespace plait::test {

TEST_CASE("OrderedWords_OfFloats_AreInTheOrderOfTheNumbers") {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  float number = -kInfinity;
  std::uint32_t before = FloatOrder::to<32>(std::bit_cast<std::uint32_t>(number));
  for (const float next : {-3e38f, -1.5f, -1.0f, -1e-30f, -1e-45f, -0.0f, 0.0f, 1e-45f, 1e-30f,
                           1.0f, 1.5f, 3e38f, kInfinity}) {
    const std::uint32_t ordered = FloatOrder::to<32>(std::bit_cast<std::uint32_t>(next));
    CHECK(ordered > before);
    before = ordered;
  }
  // Neighbours are neighbours.
  CHECK(FloatOrder::to<32>(std::bit_cast<std::uint32_t>(0.0f)) -
            FloatOrder::to<32>(std::bit_cast<std::uint32_t>(-0.0f)) ==
        1);
  CHECK(FloatOrder::to<64>(std::bit_cast<std::uint64_t>(std::nextafter(1.0, 2.0))) -
            FloatOrder::to<64>(std::bit_cast<std::uint64_t>(1.0)) ==
        1);
  CHECK(FloatOrder::to<64>(std::bit_cast<std::uint64_t>(-1.0)) <
        FloatOrder::to<64>(std::bit_cast<std::uint64_t>(1.0)));
}

TEST_CASE("OrderedWords_OfEveryKindOfFloat_AreThoseOfTheDefinitionAndComeBack") {
  CHECK(count_wrong_words([](std::uint32_t word) {
          // Negative numbers downwards from the middle, the others upwards.
          const std::uint32_t expected = word >> 31 != 0 ? ~word : word + 0x80000000u;
          const std::uint32_t ordered = FloatOrder::to<32>(word);
          return ordered == expected && FloatOrder::from<32>(ordered) == word &&
                 from_zigzag<32>(zigzag<32>(word)) == word;
        }) == 0);
}

TEST_CASE("Zigzag_SmallDifferences_AreSmallNumbers") {
  for (int difference = -100; difference <= 100; ++difference) {
    const int expected = difference >= 0 ? 2 * difference : -2 * difference - 1;
    CHECK(int(zigzag<32>(static_cast<std::uint32_t>(difference))) == expected);
    CHECK(int(zigzag<64>(static_cast<std::uint64_t>(difference))) == expected);
  }
}

}  // namespace plait::test
