// All 2^32 bit patterns of a float32 through the functions of ordered_words.h: every NaN, both
// zeros, every number.
#include <catch2/catch.hpp>
#include <cstdint>

#include "compressed/filters/ordered_words.h"

namespace plait::test {
namespace {

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

}  // namespace plait::test
