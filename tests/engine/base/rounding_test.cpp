// Rounding with a bound: no record leaves it, by an oracle in long double; twice is as once.
#include "plait/extend/rounding.h"

#include <bit>
#include <catch2/catch.hpp>
#include <cfenv>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>
#include <vector>

#include "base/number_lattice.h"
#include "plait/error.h"

namespace plait::test {
namespace {

template <class Number>
using Numbers = std::vector<Number>;

template <class Number>
AttributeSchema schema_with(std::uint32_t components) {
  return {"x", sizeof(Number) == 4 ? ComponentType::kFloat32 : ComponentType::kFloat64, components};
}

template <class Number>
Rounder rounder_for(const Numbers<Number>& base, std::uint32_t components, const char* bound) {
  return {schema_with<Number>(components), ErrorBound::parse(bound),
          std::as_bytes(std::span(base))};
}

/// Every exponent and sign, with mantissas at the ends and in the middle; and what is no number.
template <class Number>
Numbers<Number> interesting_numbers() {
  using Limits = std::numeric_limits<Number>;
  Numbers<Number> numbers = {0,
                             -Number{0},
                             Limits::infinity(),
                             -Limits::infinity(),
                             Limits::quiet_NaN(),
                             -Limits::signaling_NaN(),
                             Limits::denorm_min(),
                             -Limits::min(),
                             Limits::max(),
                             Limits::lowest()};
  for (int exponent = Limits::min_exponent - Limits::digits; exponent < Limits::max_exponent;
       ++exponent)
    for (const double mantissa : {1.0, 1.25, 1.4999999, 1.5, 1.9999999})
      for (const int sign : {-1, 1})
        numbers.push_back(static_cast<Number>(sign * std::ldexp(mantissa, exponent)));
  return numbers;
}

/// Records of numbers from all magnitudes around 1, and some with any bits.
template <class Number>
Numbers<Number> random_numbers(std::size_t count, unsigned seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  Numbers<Number> numbers;
  for (std::size_t i = 0; i < count; ++i) {
    if (i % 16 == 15) {
      using Word = typename NumberLattice<Number>::Word;
      numbers.push_back(std::bit_cast<Number>(static_cast<Word>(random())));
    } else {
      const int exponent = i % 16 < 12 ? 0 : static_cast<int>(random() % 40) - 30;
      numbers.push_back(static_cast<Number>(std::ldexp(uniform(random), exponent)));
    }
  }
  return numbers;
}

struct Errors {
  long double largest = 0, mean_square = 0;
  std::size_t changed = 0, wrong = 0;  ///< wrong: changed though it is no number or -0
};

/// The errors of records, or of numbers: in long double, where differences and squares of floats
/// are exact.
template <class Number>
Errors errors_of(const Numbers<Number>& before, const Numbers<Number>& after,
                 std::uint32_t components, bool euclidean) {
  Errors errors;
  const std::size_t group = euclidean ? components : 1;
  for (std::size_t first = 0; first + group <= before.size(); first += group) {
    long double sum = 0;
    for (std::size_t i = first; i < first + group; ++i) {
      if (std::memcmp(&before[i], &after[i], sizeof(Number)) == 0) continue;
      ++errors.changed;
      if (!std::isfinite(before[i]) || before[i] == 0) ++errors.wrong;
      const long double error =
          static_cast<long double>(before[i]) - static_cast<long double>(after[i]);
      sum += error * error;
    }
    errors.mean_square += sum;
    errors.largest = std::max(errors.largest, std::sqrt(sum));
  }
  errors.mean_square /= static_cast<long double>(before.size() / group);
  return errors;
}

template <class Number>
void check_bounds(Numbers<Number> numbers, std::uint32_t components, const Numbers<Number>& base) {
  numbers.resize(numbers.size() / components * components);
  for (const char* metric : {"component", "euclidean"})
    for (const char* bound : {"1e-9", "3e-8", "1e-7", "3.7e-7", "1e-5", "0.01", "3", "1e9"}) {
      CAPTURE(bound, metric, components, sizeof(Number));
      const std::string text = std::string(bound) + "," + metric;
      Rounder rounder = rounder_for(base, components, text.c_str());
      Numbers<Number> rounded = numbers;
      rounder.round(std::as_writable_bytes(std::span(rounded)));
      const bool euclidean = std::string_view(metric) == "euclidean";
      const Errors errors = errors_of(numbers, rounded, components, euclidean);
      const Rounding result = rounder.result();
      CHECK(errors.largest <= static_cast<long double>(result.bound));
      CHECK(result.bound == std::stod(bound));
      CHECK(errors.wrong == 0);
      CHECK(static_cast<long double>(result.largest_error) >= errors.largest);
      CHECK(static_cast<double>(errors.largest) ==
            Approx(result.largest_error).epsilon(1e-12).margin(0));
      CHECK(std::sqrt(static_cast<double>(errors.mean_square)) ==
            Approx(result.rms_error).epsilon(1e-9).margin(0));

      Numbers<Number> again = rounded;
      Rounder second = rounder_for(base, components, text.c_str());
      second.round(std::as_writable_bytes(std::span(again)));
      CHECK(std::memcmp(again.data(), rounded.data(), again.size() * sizeof(Number)) == 0);
      CHECK(second.result().largest_error == 0);
      CHECK(second.result(result) == result);
    }
}

}  // namespace

TEST_CASE("Rounding_InterestingAndRandomNumbers_StayWithinTheBound") {
  for (const std::uint32_t components : {1u, 3u, 7u}) {
    check_bounds<float>(interesting_numbers<float>(), components, {0.75f, -0.5f, 1, 0, 0, 0, 0});
    check_bounds<float>(random_numbers<float>(60'000, components), components, {0.9f});
    check_bounds<float>(random_numbers<float>(6'000, components), components, {});
    check_bounds<double>(interesting_numbers<double>(), components, {0.75});
    check_bounds<double>(random_numbers<double>(60'000, components), components, {0.9});
  }
}

TEST_CASE("Rounding_MillionsOfCoordinates_AllMoveAndStayWithinTheBound") {
  std::mt19937 random(11);
  std::uniform_real_distribution<float> coordinate(-1, 1);
  Numbers<float> numbers(3'000'000);
  for (float& number : numbers) number = coordinate(random);
  for (const char* bound : {"1e-6", "1e-4,euclidean"}) {
    Numbers<float> rounded = numbers;
    Rounder rounder = rounder_for<float>({1, -1, 0.5f}, 3, bound);
    rounder.round(std::as_writable_bytes(std::span(rounded)));
    const Errors errors =
        errors_of(numbers, rounded, 3, rounder.result().metric == ErrorMetric::kEuclidean);
    CHECK(errors.largest <= static_cast<long double>(rounder.result().bound));
    // The bound is used: the largest error found is near it, and no number was kept for being
    // rounded too far.
    CHECK(rounder.result().largest_error > 0.94 * rounder.result().bound);
    const NumberLattice<float> lattice(rounder.step());
    std::size_t off = 0;
    for (const float number : rounded) {
      const auto nearest = lattice.nearest(number);
      off += !nearest.exists || lattice.number(nearest.index) != number;
    }
    CHECK(off == 0);
  }
}

TEST_CASE("Rounding_OtherArithmeticOfTheProgram_MakesTheSameRecords") {
  const Numbers<float> numbers = random_numbers<float>(5'000, 3);
  const auto rounded = [&] {
    Numbers<float> to = numbers;
    Rounder rounder = rounder_for<float>({1}, 1, "1e-5");
    rounder.round(std::as_writable_bytes(std::span(to)));
    return to;
  };
  const Numbers<float> expected = rounded();
  for (const int direction : {FE_UPWARD, FE_DOWNWARD, FE_TOWARDZERO}) {
    std::fesetround(direction);
    const Numbers<float> made = rounded();
    std::fesetround(FE_TONEAREST);
    CHECK(std::memcmp(made.data(), expected.data(), made.size() * sizeof(float)) == 0);
  }
}

TEST_CASE("Rounding_WithSeveralBounds_AddsThemUp") {
  const Numbers<float> numbers = random_numbers<float>(3'000, 5);
  Numbers<float> rounded = numbers;
  std::optional<Rounding> found;
  for (const char* bound : {"1e-4", "3e-4", "1e-3,euclidean"}) {
    Rounder rounder = rounder_for<float>({1}, 3, bound);
    rounder.round(std::as_writable_bytes(std::span(rounded)));
    found = rounder.result(found);
    const bool euclidean = found->metric == ErrorMetric::kEuclidean;
    const Errors errors = errors_of(numbers, rounded, 3, euclidean);
    CHECK(errors.largest <= static_cast<long double>(found->largest_error));
    CHECK(found->largest_error <= found->bound);
    CHECK(std::sqrt(static_cast<double>(errors.mean_square)) <= found->rms_error);
  }
  CHECK(found->bound == Approx(4e-4 * std::sqrt(3.0) + 1e-3));
}

TEST_CASE("Rounding_RelativeBound_CountsInDiagonalsOfTheBaseRecords") {
  const Numbers<float> base = {0, 0, 0, 3, 4, 0, 1, 1, 12};
  CHECK(rounder_for(base, 3, "1e-3rel").result().bound == Approx(13e-3));
  CHECK(rounder_for(base, 3, "1e-3").result().bound == 1e-3);
}

TEST_CASE("Rounding_AttributesAndBoundsThatItDoesNotTake_AreRefused") {
  const auto refusal = [](const AttributeSchema& schema, const ErrorBound& bound,
                          const Numbers<float>& base) {
    try {
      Rounder(schema, bound, std::as_bytes(std::span(base)));
    } catch (const Error& error) {
      return error.code();
    }
    return ErrorCode::kCancelled;
  };
  const AttributeSchema floats = schema_with<float>(3);
  CHECK(refusal({"id", ComponentType::kInt32, 3}, {1}, {}) == ErrorCode::kNotSupported);
  CHECK(refusal(floats, {1e-40}, {}) == ErrorCode::kNotSupported);
  CHECK(refusal(floats, {1e40}, {}) == ErrorCode::kNotSupported);
  CHECK(refusal(floats, {1, true}, {}) == ErrorCode::kInvalidArgument);
  CHECK(refusal(floats, {1, true}, {1, 1, 1}) == ErrorCode::kInvalidArgument);
  CHECK(refusal(floats, {1, true}, {1, 1, 1, 2, 2, 2}) == ErrorCode::kCancelled);
}

TEST_CASE("ErrorBounds_Texts_AreParsedOrRefused") {
  ErrorBounds bounds;
  bounds.add("1e-5");
  bounds.add("normal=1e-3,euclidean");
  bounds.add("2e-6rel,component");
  CHECK(bounds.all().size() == 2);
  CHECK(bounds.of("position")->value == 2e-6);
  CHECK(bounds.of("position")->relative);
  CHECK(bounds.of("position")->metric == ErrorMetric::kComponent);
  CHECK_FALSE(bounds.of("normal")->relative);
  CHECK(bounds.of("normal")->metric == ErrorMetric::kEuclidean);
  CHECK_FALSE(bounds.of("colour").has_value());
  for (const char* text :
       {"",       "0",    "-1", "nan", "inf",  "-inf",        "1e-5rell",     "1e-5 rel",
        "rel",    "=1",   "x=", "x=0", "1,",   "1,manhattan", "1,euclidean,", "1e999",
        "1e-999", "0rel", "+1", " 1",  "0x1p3"}) {
    CAPTURE(text);
    CHECK_THROWS_AS(ErrorBounds().add(text), Error);
  }
}

}  // namespace plait::test
