// What filters make of single numbers and bytes; and the promises that all of them keep.
#include <algorithm>
#include <bit>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "backends/conformance.h"
#include "compressed/filters/built_in_filters.h"
#include "compressed/filters/byte_planes.h"
#include "compressed/filters/ordered_words.h"
#include "compressed/filters/residuals.h"
#include "rows/every_target.h"
#include "support/words.h"

namespace plait::test {

// Numbers as integers of the same order: a bijection of all bit patterns.

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

// Residuals of any numbers, against their definition in wide integers.

namespace {

/// The place of a number among all numbers: 2^31 for +0, 2^31 - 1 for -0.
std::uint64_t residual_place_of(std::uint32_t bits) {
  constexpr std::uint64_t kHalf = std::uint64_t{1} << 31;
  return bits < kHalf ? kHalf + bits : kHalf - 1 - (bits - kHalf);
}

std::uint32_t zigzag_of(std::uint64_t number, std::uint64_t prediction) {
  const auto up = static_cast<std::uint32_t>(number - prediction);
  const auto down = static_cast<std::uint32_t>(prediction - number);
  // The shorter way round; half way counts as down.
  return up < down ? 2 * up : up == 0 ? 0 : 2 * down - 1;
}

std::vector<float> some_numbers() {
  using Limits = std::numeric_limits<float>;
  std::vector<float> numbers = {0.0f,
                                -0.0f,
                                1.0f,
                                -1.0f,
                                Limits::max(),
                                -Limits::max(),
                                Limits::min(),
                                -Limits::min(),
                                Limits::denorm_min(),
                                3.25e-5f,
                                -Limits::denorm_min(),
                                Limits::infinity(),
                                -Limits::infinity()};
  std::mt19937 random(1);
  for (int i = 0; i < 200; ++i)
    numbers.push_back(std::bit_cast<float>(static_cast<std::uint32_t>(random())));
  return numbers;
}

}  // namespace

TEST_CASE("Residuals_OfPairsOfNumbers_AreThoseOfTheDefinition") {
  for (const float number : some_numbers())
    for (const float prediction : some_numbers()) {
      const float counted = prediction == prediction ? prediction : 0.0f;
      const std::uint32_t expected =
          zigzag_of(residual_place_of(std::bit_cast<std::uint32_t>(number)),
                    residual_place_of(std::bit_cast<std::uint32_t>(counted)));
      const std::uint32_t found = residual(number, prediction);
      CHECK(found == expected);
      CHECK(std::bit_cast<std::uint32_t>(from_residual(found, prediction)) ==
            std::bit_cast<std::uint32_t>(number));
    }
}

TEST_CASE("Residuals_OfFloats_GiveThemBack") {
  for (const float prediction : {0.0f, -1.5f, std::numeric_limits<float>::infinity()}) {
    CAPTURE(prediction);
    CHECK(count_wrong_words([&](std::uint32_t bits) {
            const std::uint32_t coded = residual(std::bit_cast<float>(bits), prediction);
            return std::bit_cast<std::uint32_t>(from_residual(coded, prediction)) == bits;
          }) == 0);
  }
}

TEST_CASE("Residuals_OfDoubles_GiveTheNumberBack") {
  std::mt19937_64 random(2);
  for (int i = 0; i < 100'000; ++i) {
    const auto number = std::bit_cast<double>(random()),
               prediction = std::bit_cast<double>(random());
    CHECK(std::bit_cast<std::uint64_t>(from_residual(residual(number, prediction), prediction)) ==
          std::bit_cast<std::uint64_t>(number));
  }
  CHECK(residual(1.0, 1.0) == 0);
  CHECK(residual(-0.0, 0.0) == 1);
}

// The loops over bytes, against their definitions, with every instruction set of this processor.

namespace {

using Bytes = std::vector<std::byte>;

Bytes random_bytes(std::size_t size, unsigned seed) {
  std::mt19937 random(seed);
  Bytes bytes(size);
  for (std::byte& byte : bytes) byte = static_cast<std::byte>(random());
  return bytes;
}

std::size_t different(const Bytes& a, const Bytes& b) {
  std::size_t count = a.size() == b.size() ? 0 : 1;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) count += a[i] != b[i];
  return count;
}

constexpr std::size_t kCounts[] = {0,  1,  2,  7,  8,   9,   15,  16,  17,   31,  32,
                                   33, 63, 64, 65, 127, 128, 129, 255, 1000, 4099};

}  // namespace

TEST_CASE("BytePlanes_SplitAndJoin_AreTheDefinitionOnEveryInstructionSet") {
  fused_rows::on_every_target([](const char* target) {
    for (const std::size_t width : {2u, 4u, 8u})
      for (const std::size_t count : kCounts) {
        CAPTURE(target, width, count);
        const Bytes numbers = random_bytes(count * width, 1);
        Bytes expected(numbers.size()), planes(numbers.size()), back(numbers.size());
        for (std::size_t i = 0; i < count; ++i)
          for (std::size_t plane = 0; plane < width; ++plane)
            expected[plane * count + i] = numbers[i * width + plane];
        split_planes(numbers.data(), count, width, planes.data());
        CHECK(different(planes, expected) == 0);
        join_planes(planes.data(), count, width, back.data());
        CHECK(different(back, numbers) == 0);
      }
  });
}

TEST_CASE("ShuffleFilter_AnyWidthAndSize_IsTheDefinitionAndItsInverse") {
  for (const std::size_t width : {2u, 4u, 8u}) {
    const auto filter = make_shuffle_filter(width);
    for (const std::size_t size :
         {0u, 1u, 2u, 7u, 8u, 9u, 63u, 64u, 65u, 127u, 128u, 1000u, 4096u, 70000u}) {
      INFO(width << ' ' << size);
      const auto raw = make_content(size, Content::kRandom, 1);
      std::vector<std::byte> filtered(size), back(size);
      filter->encode({}, raw, filtered);
      const std::size_t count = size / width;
      std::size_t wrong = 0;
      for (std::size_t at = 0; at < size; ++at) {
        const std::size_t place = at < count * width ? at % width * count + at / width : at;
        if (filtered[place] != raw[at]) ++wrong;
      }
      CHECK(wrong == 0);
      filter->decode({}, filtered, back);
      CHECK(back == raw);
    }
  }
}

}  // namespace plait::test
