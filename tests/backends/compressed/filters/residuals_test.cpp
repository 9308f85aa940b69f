// Residuals of any numbers, against their definition in wide integers.
#include "compressed/filters/residuals.h"

#include <bit>
#include <catch2/catch.hpp>
#include <cstdint>
#include <limits>
#include <random>
#include <vector>

#include "support/words.h"

namespace plait::test {
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

}  // namespace plait::test
