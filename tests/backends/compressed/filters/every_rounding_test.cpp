// All 2^32 words through the map of the filter lattice, and a hundred million numbers through
// rounding: slow tests. With PLAIT_ROUNDED_NUMBERS=1000000000 in the environment it is as many.
#include <bit>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <random>
#include <string>
#include <vector>

#include "base/default_arithmetic.h"
#include "base/number_lattice.h"
#include "plait/extend/rounding.h"

namespace plait::test {

TEST_CASE("NumberLattice_EveryWord_HasAnImageOfItsOwn") {
  const DefaultArithmetic arithmetic;
  const NumberLattice<float> lattice(2e-6);
  std::vector<bool> taken(std::size_t{1} << 32);
  std::uint64_t wrong = 0;
  std::uint32_t bits = 0;
  do {
    const std::uint32_t word = lattice.word(std::bit_cast<float>(bits));
    wrong += std::bit_cast<std::uint32_t>(lattice.number_of_word(word)) != bits;
    wrong += taken[word];
    taken[word] = true;
  } while (++bits != 0);
  CHECK(wrong == 0);
}

TEST_CASE("Rounding_OfAHundredMillionNumbers_KeepsTheBound") {
  const char* const wanted = std::getenv("PLAIT_ROUNDED_NUMBERS");
  const std::uint64_t least = wanted ? std::stoull(wanted) : 100'000'000;
  constexpr std::uint64_t kBounds = 7, kNumbers = 3 << 14;
  const std::uint64_t rounds = (least + kBounds * kNumbers - 1) / (kBounds * kNumbers);
  std::mt19937 random(1);
  const std::vector<float> base = {1, 1, 1};
  std::uint64_t violations = 0, numbers = 0;
  for (const char* bound :
       {"2e-7", "1e-6", "1e-5", "1e-3", "1e-6,euclidean", "1e-4,euclidean", "0.3"}) {
    const ErrorBound parsed = ErrorBound::parse(bound);
    const bool euclidean = parsed.metric == ErrorMetric::kEuclidean;
    Rounder rounder({"x", ComponentType::kFloat32, 3}, parsed, std::as_bytes(std::span(base)));
    const auto most = static_cast<long double>(rounder.result().bound);
    std::vector<float> before(kNumbers), after;
    for (std::uint64_t round = 0; round < rounds; ++round) {
      // One in 16 has any bits; the others are coordinates.
      for (std::size_t i = 0; i < before.size(); ++i) {
        const auto word = static_cast<std::uint32_t>(random());
        before[i] = i % 16 == 0
                        ? std::bit_cast<float>(word)
                        : std::ldexp(static_cast<float>(static_cast<std::int32_t>(word)), -31);
      }
      after = before;
      rounder.round(std::as_writable_bytes(std::span(after)));
      for (std::size_t i = 0; i < before.size(); i += 3) {
        long double sum = 0, largest = 0;
        for (std::size_t k = i; k < i + 3; ++k) {
          if (std::memcmp(&before[k], &after[k], sizeof(float)) == 0) continue;
          const long double error =
              std::abs(static_cast<long double>(before[k]) - static_cast<long double>(after[k]));
          sum += error * error;
          largest = std::max(largest, error == error ? error : most * 2);
        }
        violations += !((euclidean ? std::sqrt(sum) : largest) <= most);
      }
      numbers += before.size();
    }
  }
  CHECK(numbers >= least);
  CHECK(violations == 0);
}

}  // namespace plait::test
