// All 2^32 bit patterns of a float32 through the functions of ordered_words.h: every NaN, both
// zeros, every number.
#include <catch2/catch.hpp>
#include <cstdint>

#include "compressed/filters/ordered_words.h"

namespace plait::test {
namespace {

typedef std::uint32_t Lanes __attribute__((vector_size(16)));

constexpr std::uint64_t kAll = std::uint64_t{1} << 32;

}  // namespace

TEST_CASE("OrderedWords_AllBitPatternsOfAFloat_ComeBack") {
  std::uint64_t wrong = 0;
  for (std::uint64_t bits = 0; bits < kAll; ++bits) {
    const auto word = static_cast<std::uint32_t>(bits);
    // The definition: negative numbers downwards from the middle, the others upwards.
    const std::uint32_t expected = word >> 31 != 0 ? ~word : word + 0x80000000u;
    const std::uint32_t ordered = FloatOrder::to<32>(word), number = zigzag<32>(word);
    wrong += ordered != expected || FloatOrder::from<32>(ordered) != word ||
             from_zigzag<32>(number) != word;
  }
  CHECK(wrong == 0);
}

TEST_CASE("OrderedWords_AllBitPatternsInLanes_AreThoseOfSingleWords") {
  std::uint64_t wrong = 0;
  for (std::uint64_t bits = 0; bits < kAll; bits += 4) {
    const auto first = static_cast<std::uint32_t>(bits);
    const Lanes words = Lanes{0, 1, 2, 3} + first;
    const Lanes ordered = FloatOrder::to<32>(words), back = FloatOrder::from<32>(ordered),
                numbers = zigzag<32>(words), again = from_zigzag<32>(numbers);
    for (std::uint32_t lane = 0; lane < 4; ++lane)
      wrong += ordered[lane] != FloatOrder::to<32>(first + lane) || back[lane] != first + lane ||
               numbers[lane] != zigzag<32>(first + lane) || again[lane] != first + lane;
  }
  CHECK(wrong == 0);
}

}  // namespace plait::test
