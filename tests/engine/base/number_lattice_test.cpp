// The map of words to lattice indices, against its definition in wide integers.
#include "base/number_lattice.h"

#include <bit>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <map>
#include <random>
#include <vector>

#include "base/default_arithmetic.h"
#include "support/words.h"

namespace plait::test {
namespace {

const std::vector<double> kSteps = {1e-6, 2e-5, 0.1, 1, 3, 0x1p-20, 1.7e30, kLeastStep, kMostStep};

template <class Number>
typename NumberLattice<Number>::Word bits_of(Number number) {
  return std::bit_cast<typename NumberLattice<Number>::Word>(number);
}

/// Words near numbers of the lattice, near the indices themselves, and any.
template <class Number>
std::vector<typename NumberLattice<Number>::Word> some_words(const NumberLattice<Number>& lattice) {
  using Word = typename NumberLattice<Number>::Word;
  std::vector<Word> words = {0, NumberLattice<Number>::kCentre, static_cast<Word>(~Word{0})};
  std::mt19937_64 random(4);
  for (int i = 0; i < 20'000; ++i) {
    words.push_back(static_cast<Word>(random()));
    const auto index =
        static_cast<std::int64_t>(
            random() % static_cast<std::uint64_t>(2 * NumberLattice<Number>::kMost + 1)) -
        NumberLattice<Number>::kMost;
    const auto offset = static_cast<Word>(random() % 3 - 1);
    words.push_back(static_cast<Word>(bits_of(lattice.number(index)) + offset));
    words.push_back(static_cast<Word>(static_cast<Word>(index) + offset));
  }
  for (const std::int64_t index : {NumberLattice<Number>::kMost, NumberLattice<Number>::kMost - 1})
    for (const int sign : {-1, 1})
      for (const int offset : {-1, 0, 1})
        words.push_back(
            static_cast<Word>(bits_of(lattice.number(sign * index)) + static_cast<Word>(offset)));
  return words;
}

template <class Number>
void check_map() {
  using Lattice = NumberLattice<Number>;
  const DefaultArithmetic arithmetic;
  for (const double step : kSteps) {
    CAPTURE(step, sizeof(Number));
    const Lattice lattice(step);
    std::size_t wrong = 0;
    std::map<typename Lattice::Word, typename Lattice::Word> source;
    for (const auto bits : some_words(lattice)) {
      const auto word = lattice.word(std::bit_cast<Number>(bits));
      wrong += bits_of(lattice.number_of_word(word)) != bits;
      wrong += source.emplace(word, bits).first->second != bits;  // two words with one image
      wrong += bits_of(std::bit_cast<Number>(Lattice::from_ordered(
                   lattice.word(lattice.number_of_word(bits))))) != Lattice::from_ordered(bits);
    }
    for (std::int64_t index = -1000; index <= 1000; ++index) {
      const Number number = static_cast<Number>(static_cast<double>(index) * step);
      wrong += bits_of(lattice.number(index)) != bits_of(number + Number{0});
      wrong += lattice.word(number + Number{0}) !=
               Lattice::kCentre + static_cast<typename Lattice::Word>(index);
    }
    CHECK(wrong == 0);
    // Numbers of the lattice have the words of their indices, up to the last.
    CHECK(lattice.word(lattice.number(Lattice::kMost)) == Lattice::kCentre + Lattice::kMost);
    CHECK(lattice.word(lattice.number(-Lattice::kMost)) == Lattice::kCentre - Lattice::kMost);
    const auto beyond = static_cast<Number>((static_cast<double>(Lattice::kMost) + 1) * step);
    CHECK(lattice.word(beyond) == Lattice::ordered(bits_of(beyond)));
  }
}

}  // namespace

TEST_CASE("NumberLattice_AnyWord_IsMappedOnceAndBack") {
  check_map<float>();
  check_map<double>();
}

TEST_CASE("NumberLattice_WordsOfEveryKindOfFloat_ComeBack") {
  const DefaultArithmetic arithmetic;
  const NumberLattice<float> lattice(2e-6);
  CHECK(count_wrong_words([&](std::uint32_t bits) {
          const std::uint32_t word = lattice.word(std::bit_cast<float>(bits));
          return bits_of(lattice.number_of_word(word)) == bits;
        }) == 0);
}

TEST_CASE("NumberLattice_Prediction_IsTheNearestIndexOrThePlaceOfANumber") {
  const DefaultArithmetic arithmetic;
  using Lattice = NumberLattice<float>;
  const Lattice lattice(0.1);
  const auto index = [&](float prediction) {
    return static_cast<std::int32_t>(lattice.predicted_word(prediction) - Lattice::kCentre);
  };
  CHECK(index(0.34f) == 3);
  CHECK(index(-0.36f) == -4);
  CHECK(index(-0.0f) == 0);
  CHECK(index(std::numeric_limits<float>::denorm_min()) == 0);
  CHECK(index(std::numeric_limits<float>::quiet_NaN()) == 0);
  CHECK(lattice.predicted_word(1e9f) == Lattice::ordered(bits_of(1e9f)));
  CHECK(lattice.predicted_word(-std::numeric_limits<float>::infinity()) ==
        Lattice::ordered(bits_of(-std::numeric_limits<float>::infinity())));
}

}  // namespace plait::test
