#include "tune/figures.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>

namespace plait::tune {
namespace {

Trial figures_trial(std::vector<Outcome> outcomes) {
  return {0, 4096, "none", 4096, false, std::move(outcomes)};
}

/// `raw` bytes to `stored`, both directions at a second a byte.
Outcome outcome(double raw, double stored) { return {raw, stored, raw, raw, 1}; }

}  // namespace

TEST_CASE("RatioOfSums_OfAWhole_HasNoSpread") {
  const Figure figure = ratio_of_sums({1, 2, 3}, {1, 1, 1}, true);
  CHECK(figure.value == Approx(0.5));
  CHECK(figure.low == figure.value);
  CHECK(figure.high == figure.value);
}

TEST_CASE("RatioOfSums_OfTwoPairs_IsTheClosedForm") {
  // Residuals -1 and 1 around the ratio 2, mean of x 1; Student's factor of one degree is 12.71.
  const Figure figure = ratio_of_sums({1, 1}, {1, 3}, false);
  CHECK(figure.value == Approx(2));
  CHECK(figure.low == 0);
  CHECK(figure.high == Approx(2 + 12.71 * std::sqrt(2.0 / 2)));
  CHECK(std::isinf(ratio_of_sums({1}, {1}, false).high));
}

TEST_CASE("MeanOfRatios_OfThreePairs_IsTheClosedForm") {
  const Figure figure = mean_of_ratios({1, 10, 100}, {4, 50, 600});
  CHECK(figure.value == Approx(5));
  CHECK(figure.high == Approx(5 + 4.303 * std::sqrt(2.0 / 6)));
  CHECK(figure.low == Approx(5 - 4.303 * std::sqrt(2.0 / 6)));
  CHECK(std::isinf(mean_of_ratios({2}, {1}).high));
}

TEST_CASE("Intervals_OfRandomSamples_HaveTheTrueFigureInThem") {
  // Blocks of two sizes, whose ratios are 1 and 2: chosen by bytes, and at random.
  std::mt19937 random(3);
  int by_bytes = 0, at_random = 0;
  constexpr int kRuns = 400;
  for (int run = 0; run < kRuns; ++run) {
    std::vector<double> x, y, u, v;
    for (int i = 0; i < 16; ++i) {
      const bool large = random() % 5 < 4;  // 4 bytes or 1, as many of each: 4 of 5 chances
      x.push_back(large ? 4 : 1);
      y.push_back(large ? 8 : 1);
      const bool even = random() % 2 == 0;
      u.push_back(even ? 4 : 1);
      v.push_back(even ? 8 : 1);
    }
    const Figure bytes = mean_of_ratios(x, y), any = ratio_of_sums(u, v, false);
    by_bytes += bytes.low <= 1.8 && 1.8 <= bytes.high;
    at_random += any.low <= 1.8 && 1.8 <= any.high;
  }
  CHECK(by_bytes > kRuns * 85 / 100);
  CHECK(at_random > kRuns * 85 / 100);
}

TEST_CASE("Rates_CompareTheSameBytes") {
  Trials trials;
  trials.attributes.push_back({{"position"}, 1000, 3, false});
  trials.trials = {figures_trial({outcome(10, 5), outcome(10, 5), outcome(10, 10)}),
                   figures_trial({outcome(10, 2), outcome(10, 2), {}})};
  CHECK(common_parts(trials, 0) == std::vector<std::size_t>{0, 1});
  CHECK(rates_of(trials, trials.trials[0]).stored.value == Approx(0.5));
  CHECK(rates_of(trials, trials.trials[1]).stored.value == Approx(0.2));
  CHECK(rates_of(trials, trials.trials[0], 0).stored.value == Approx(0.5));
  // Nothing in common: each by what it has.
  trials.trials.push_back(figures_trial({{}, {}, outcome(10, 1)}));
  CHECK(common_parts(trials, 0).empty());
  CHECK(rates_of(trials, trials.trials[0]).stored.value == Approx(2.0 / 3));
  CHECK(rates_of(trials, trials.trials[2]).stored.value == Approx(0.1));
}

TEST_CASE("Rates_OfAWholeAttribute_KnowTheSizeExactly") {
  Trials trials;
  trials.attributes.push_back({{"position"}, 110, 2, true});
  trials.trials = {figures_trial({outcome(10, 10), outcome(100, 20)})};
  const Rates rates = rates_of(trials, trials.trials[0]);
  CHECK(rates.stored.value == Approx(30.0 / 110));
  CHECK(rates.stored.high == rates.stored.low);
  CHECK(rates.decode.value == Approx(1));
  // Interrupted: a part of it is a sample again.
  trials.trials[0].outcomes[1] = {};
  CHECK(std::isinf(rates_of(trials, trials.trials[0]).stored.high));
}

}  // namespace plait::tune
