// Statistics of measurements against published tables, worked examples of textbooks, and how often
// intervals contain a truth that is known.
#include "instrument/statistics.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numeric>
#include <random>

#include "plait/error.h"

namespace plait::instrument {
namespace {

std::vector<double> counted(std::size_t count) {
  std::vector<double> values(count);
  std::iota(values.begin(), values.end(), 1.0);
  return values;
}

/// Seeded noise: exp of a sum of twelve uniform numbers, nearly normal.
class Noise {
 public:
  explicit Noise(std::uint64_t seed) : random_(seed) {}
  double factor(double spread) {
    double sum = -6;
    for (int at = 0; at < 12; ++at) sum += static_cast<double>(random_() >> 11) * 0x1p-53;
    return std::exp(spread * sum);
  }

 private:
  std::mt19937_64 random_;
};

TEST_CASE("quantiles are linear between order statistics") {
  CHECK(median(std::vector{3.0, 1.0, 2.0}) == 2);
  CHECK(median(std::vector{4.0, 1.0, 2.0, 3.0}) == 2.5);
  CHECK(median(std::vector{7.0}) == 7);
  // The default of R: quantile(1:4, c(0.25, 0.9)) is 1.75, 3.7.
  CHECK(quantile(std::vector{1.0, 2.0, 3.0, 4.0}, 0.25) == 1.75);
  CHECK(quantile(std::vector{1.0, 2.0, 3.0, 4.0}, 0.9) == Approx(3.7));
  CHECK(quantile(counted(101), 0.99) == 100);
  CHECK(quantile(counted(5), 0) == 1);
  CHECK(quantile(counted(5), 1) == 5);
}

TEST_CASE("what is no sample is refused") {
  CHECK_THROWS_AS(median({}), Error);
  CHECK_THROWS_AS(mean_interval({}), Error);
  CHECK_THROWS_AS(geometric_interval({}), Error);
  CHECK_THROWS_AS(compare_paired(counted(3), counted(2)), Error);
  CHECK_THROWS_AS(compare_unpaired(counted(3), {}), Error);
}

TEST_CASE("Student's factors are those of the published tables") {
  CHECK(student_factor(1, 0.95) == Approx(12.706).margin(1e-3));
  CHECK(student_factor(4, 0.95) == Approx(2.776).margin(1e-3));
  CHECK(student_factor(9, 0.99) == Approx(3.250).margin(1e-3));
  CHECK(student_factor(1e6, 0.95) == Approx(1.960).margin(1e-3));
}

TEST_CASE("the paired example of Student is that of his paper") {
  // Additional hours of sleep by two drugs: t = 4.0621 with nine degrees, p = 0.00283.
  const std::vector<double> a = {0.7, -1.6, -0.2, -1.2, -0.1, 3.4, 3.7, 0.8, 0.0, 2.0};
  const std::vector<double> b = {1.9, 0.8, 1.1, 0.1, -0.1, 4.4, 5.5, 1.6, 4.6, 3.4};
  std::vector<double> of_a, of_b, difference;
  for (std::size_t at = 0; at < a.size(); ++at) {
    of_a.push_back(std::exp(a[at]));
    of_b.push_back(std::exp(b[at]));
    difference.push_back(b[at] - a[at]);
  }
  const Comparison found = compare_paired(of_a, of_b);
  CHECK(found.p_value == Approx(0.002833).margin(1e-6));
  CHECK(std::log(found.factor.value) == Approx(1.58));
  CHECK(std::log(found.factor.low) == Approx(0.7001).margin(1e-4));
  CHECK(std::log(found.factor.high) == Approx(2.4599).margin(1e-4));
  CHECK(mean_interval(difference).low == Approx(0.7001).margin(1e-4));
  // The same as two samples, by Welch: t = 1.8608 with 17.776 degrees, p = 0.07939.
  CHECK(compare_unpaired(of_a, of_b).p_value == Approx(0.07939).margin(1e-5));
}

TEST_CASE("one value, and values without a spread") {
  const Comparison one = compare_paired(std::vector{2.0}, std::vector{3.0});
  CHECK(one.factor.value == Approx(1.5));
  CHECK(one.factor.confidence == 0);
  CHECK(one.p_value == 1);
  const Comparison exact = compare_with_one(std::vector{2.0, 2.0, 2.0});
  CHECK(exact.p_value == 0);
  CHECK(exact.factor.low == exact.factor.high);
  CHECK(compare_with_one(std::vector{1.0, 1.0}).p_value == 1);
  CHECK(geometric_interval(std::vector{1.0, 4.0}).value == Approx(2));
  CHECK(geometric_interval(std::vector{5.0}).relative_half_width() == 0);
}

TEST_CASE("intervals contain the truth as often as they say, and cancel what drifts") {
  Noise noise(11);
  constexpr int kTrials = 2000;
  for (const std::size_t count : {3u, 5u, 12u}) {
    int paired = 0, unpaired = 0;
    for (int trial = 0; trial < kTrials; ++trial) {
      std::vector<double> a, b, c;
      for (std::size_t at = 0; at < count; ++at) {
        const double drift = noise.factor(0.5);
        a.push_back(drift * noise.factor(0.03));
        b.push_back(drift * 1.2 * noise.factor(0.03));
        c.push_back(1.2 * a[at] / drift * noise.factor(0.06) / noise.factor(0.03));
      }
      const Comparison one = compare_paired(a, b);
      paired += one.factor.low <= 1.2 && 1.2 <= one.factor.high;
      if (count == 12) CHECK(one.factor.relative_half_width() < 0.08);
      const Comparison two = compare_unpaired(std::vector<double>(count, 1.0), c);
      unpaired += two.factor.low <= 1.2 && 1.2 <= two.factor.high;
    }
    INFO(count);
    CHECK(std::abs(paired - 0.95 * kTrials) < 60);
    CHECK(std::abs(unpaired - 0.95 * kTrials) < 60);
  }
}

/// Spreads of `count` comparisons with `rounds` rounds, as Smyth's model draws them: a variance
/// that is 0.01 * degrees / chi²(degrees), or just 0.01, and its estimate from the rounds.
std::vector<Spread> drawn_spreads(std::mt19937_64& random, int count, int rounds, double degrees) {
  std::vector<Spread> spreads;
  for (int at = 0; at < count; ++at) {
    const double truth =
        degrees == 0 ? 0.01
                     : 0.01 * degrees / std::chi_squared_distribution<double>(degrees)(random);
    const double of_rounds = rounds - 1;
    spreads.push_back(
        {truth * std::chi_squared_distribution<double>(of_rounds)(random) / of_rounds, of_rounds});
  }
  return spreads;
}

TEST_CASE("spreads in common are those that they were drawn from") {
  std::mt19937_64 random(3);
  for (const int rounds : {3, 6}) {
    const Spread found = common_spread(drawn_spreads(random, 20000, rounds, 6));
    CHECK(found.variance == Approx(0.01).epsilon(0.03));
    CHECK(found.degrees == Approx(6).epsilon(0.08));
    const Spread equal = common_spread(drawn_spreads(random, 20000, rounds, 0));
    CHECK(equal.variance == Approx(0.01).epsilon(0.1));
    CHECK(equal.degrees == 20);
  }
  // What differs by a factor of a hundred lends nothing.
  std::vector<Spread> different(20, Spread{1e-4, 30});
  different.insert(different.end(), 20, Spread{1, 30});
  CHECK(common_spread(different).degrees < 0.5);
  // Three spreads are too few, and what has no variance or no degrees is none.
  std::vector<Spread> few(3, Spread{0.01, 2});
  CHECK(common_spread(few).degrees == 0);
  few.insert(few.end(), {{0, 2}, {0.01, 0}});
  CHECK(common_spread(few).degrees == 0);
  few.push_back({0.01, 2});
  CHECK(common_spread(few).degrees == 20);
}

TEST_CASE("a spread in common makes intervals of three rounds narrow, and they still hold") {
  Noise noise(17);
  constexpr int kTrials = 1500;
  constexpr std::size_t kPairs = 12;
  constexpr double kConfidence = 0.99;
  // Equally noisy pairs; and four of twelve with three times the noise of the others.
  for (const double noisy : {0.1, 0.3}) {
    int alone = 0, together = 0;
    double width_alone = 0, width_together = 0;
    for (int trial = 0; trial < kTrials; ++trial) {
      std::vector<std::vector<double>> pairs(kPairs);
      std::vector<Spread> spreads;
      for (std::size_t at = 0; at < kPairs; ++at) {
        for (int round = 0; round < 3; ++round)
          pairs[at].push_back(2 * noise.factor(at < kPairs / 3 ? noisy : 0.1));
        const double spread = compare_with_one(pairs[at]).spread;
        spreads.push_back({spread * spread, 2});
      }
      const Spread common = common_spread(spreads);
      for (const std::vector<double>& pair : pairs) {
        const Estimate one = compare_with_one(pair, kConfidence).factor;
        const Estimate all = compare_with_one(pair, kConfidence, common).factor;
        alone += one.low <= 2 && 2 <= one.high;
        together += all.low <= 2 && 2 <= all.high;
        width_alone += std::log(one.high / one.low);
        width_together += std::log(all.high / all.low);
      }
    }
    CAPTURE(noisy, alone, together, width_alone, width_together);
    CHECK(together > (kConfidence - 0.015) * kTrials * kPairs);
    CHECK(width_together < 0.6 * width_alone);
  }
}

TEST_CASE("p values are adjusted as in the paper, and intervals agree with them") {
  // Benjamini and Hochberg (1995), section 4: 15 tests, of which their procedure rejects four at 5
  // %.
  const std::vector<double> p = {0.0001, 0.0004, 0.0019, 0.0095, 0.0201, 0.0278, 0.0298, 0.0344,
                                 0.0459, 0.3240, 0.4262, 0.5719, 0.6528, 0.7590, 1.000};
  const std::vector<double> adjusted = adjusted_p_values(p);
  CHECK(std::ranges::count_if(adjusted, [](double value) { return value <= 0.05; }) == 4);
  CHECK(adjusted[0] == Approx(0.0015));
  CHECK(adjusted[3] == Approx(0.035625));
  CHECK(adjusted[14] == 1);
  CHECK(adjusted_p_values({}).empty());
  // The fourth p value is in its interval's level, the fifth is not.
  const double level = 1 - confidence_among(p, 0.05);
  CHECK(level == Approx(0.05 * 4 / 15));
  CHECK(p[3] <= level);
  CHECK(p[4] > level);
  CHECK(confidence_among({}, 0.05) == Approx(0.95));
}

}  // namespace
}  // namespace plait::instrument
