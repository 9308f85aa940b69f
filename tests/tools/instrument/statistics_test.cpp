// Statistics of measurements against published tables, worked examples of textbooks, and counting
// by brute force.
#include "instrument/statistics.h"

#include <algorithm>
#include <bit>
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
  CHECK_THROWS_AS(median_interval({}), Error);
  CHECK_THROWS_AS(median(std::vector<double>(kMostValues + 1)), Error);
  CHECK_THROWS_AS(mann_whitney(counted(3), {}), Error);
  CHECK_THROWS_AS(paired_ratio_interval(counted(3), counted(2)), Error);
}

TEST_CASE("the interval of a median lies between the published order statistics") {
  // W. Conover, "Practical nonparametric statistics"; ISO 16269-7, two-sided, 95 %:
  // sample size, lower place, upper place, attained confidence.
  struct Row {
    std::size_t count;
    double low, high, confidence;
  };
  for (const Row& row :
       {Row{6, 1, 6, 0.96875}, Row{7, 1, 7, 0.984375}, Row{9, 2, 8, 0.9609375},
        Row{10, 2, 9, 0.978515625}, Row{15, 4, 12, 0.96484375}, Row{20, 6, 15, 0.95861},
        Row{25, 8, 18, 0.95671}, Row{30, 10, 21, 0.95723}}) {
    const Estimate found = median_interval(counted(row.count));
    INFO(row.count);
    CHECK(found.low == row.low);
    CHECK(found.high == row.high);
    CHECK(found.confidence == Approx(row.confidence).margin(1e-5));
    CHECK(found.count == row.count);
  }
  // Fewer than six values give their range, and say what that is worth.
  const Estimate five = median_interval(counted(5));
  CHECK(five.low == 1);
  CHECK(five.high == 5);
  CHECK(five.confidence == Approx(0.9375));
  CHECK(median_interval(counted(1)).confidence == Approx(0).margin(1e-12));
}

TEST_CASE("the interval of a median contains the truth as often as it says") {
  std::mt19937_64 random(7);
  for (const std::size_t count : {5u, 12u, 40u}) {
    int hits = 0;
    double confidence = 0;
    for (int trial = 0; trial < 2000; ++trial) {
      std::vector<double> values(count);
      for (double& value : values)  // exponential times: the median is ln 2
        value = -std::log1p(-static_cast<double>(random() >> 11) * 0x1p-53);
      const Estimate found = median_interval(values);
      confidence = found.confidence;
      hits += found.low <= std::log(2.0) && std::log(2.0) <= found.high;
    }
    CHECK(hits / 2000.0 == Approx(confidence).margin(0.02));
  }
}

TEST_CASE("ratios are taken inside a round, so that drift cancels") {
  const std::vector<double> floors = {1, 2, 4, 8, 16, 32};
  std::vector<double> values = floors;
  for (double& value : values) value *= 1.5;
  const Estimate found = paired_ratio_interval(values, floors);
  CHECK(found.value == 1.5);
  CHECK(found.low == 1.5);
  CHECK(found.high == 1.5);
  CHECK(found.relative_half_width() == 0);
}

TEST_CASE("Mann and Whitney's test has the published critical values") {
  // Two-sided, 5 %: the largest U that is significant (Mann and Whitney 1947 and every table
  // since).
  struct Row {
    std::size_t first, second;
    double critical;
  };
  for (const Row& row : {Row{4, 4, 0}, Row{5, 5, 2}, Row{7, 9, 12}, Row{8, 8, 13}, Row{10, 10, 23},
                         Row{20, 20, 127}}) {
    // U as a choice of places: begin with all of `second` below and move values up one by one.
    std::vector<double> ranks = counted(row.first + row.second);
    const auto p_of = [&](double u) {
      std::vector<double> second(ranks.begin(), ranks.begin() + static_cast<long>(row.second));
      for (std::size_t at = row.second; u > 0 && at > 0; --at) {
        const double step = std::min(u, static_cast<double>(row.first));
        second[at - 1] += step;
        u -= step;
      }
      std::vector<double> first;
      for (const double rank : ranks)
        if (std::find(second.begin(), second.end(), rank) == second.end()) first.push_back(rank);
      return mann_whitney(first, second).p_value;
    };
    INFO(row.first << " and " << row.second);
    CHECK(p_of(row.critical) <= 0.05);
    CHECK(p_of(row.critical + 1) > 0.05);
  }
  // Closed form: five values all below five others, one arrangement of 252 on either side.
  const RankTest apart = mann_whitney(counted(5), std::vector{6.0, 7.0, 8.0, 9.0, 10.0});
  CHECK(apart.statistic == 25);
  CHECK(apart.p_value == Approx(2.0 / 252));
}

TEST_CASE("Hollander and Wolfe's permeability example") {
  // M. Hollander, D. Wolfe, "Nonparametric statistical methods" (1973), table 4.1; R's ?wilcox.test
  // gives W = 35 and a one-sided p of 0.1272.
  const std::vector<double> x = {0.80, 0.83, 1.89, 1.04, 1.45, 1.38, 1.91, 1.64, 0.73, 1.46};
  const std::vector<double> y = {1.15, 0.88, 0.90, 0.74, 1.21};
  const RankTest found = mann_whitney(y, x);
  CHECK(found.statistic == 35);
  CHECK(found.p_value == Approx(2 * 0.1272).margin(2e-4));
  const Estimate shift = shift_interval(y, x);
  CHECK(shift.value == Approx(0.305));
  CHECK(shift.low == Approx(-0.15));  // the book's interval, of 96 %
  CHECK(shift.high == Approx(0.76));
  CHECK(shift.confidence == Approx(0.96).margin(0.005));
}

TEST_CASE("rank tests with ties count all arrangements") {
  std::mt19937_64 random(11);
  for (int trial = 0; trial < 40; ++trial) {
    const std::size_t n = 3 + random() % 4;
    const std::size_t m = 3 + random() % 4;
    std::vector<double> all(n + m);
    for (double& value : all) value = static_cast<double>(random() % 5);
    // U of the subset `chosen` by its definition.
    const auto u_of = [&](unsigned chosen) {
      double u = 0;
      for (std::size_t a = 0; a < all.size(); ++a)
        for (std::size_t b = 0; b < all.size(); ++b)
          if (!(chosen >> a & 1) && (chosen >> b & 1))
            u += all[b] > all[a] ? 1 : all[b] == all[a] ? 0.5 : 0;
      return u;
    };
    const unsigned last = ((1u << m) - 1) << n;  // the values behind the first n
    double lower = 0;
    double upper = 0;
    double total = 0;
    for (unsigned chosen = 0; chosen < 1u << all.size(); ++chosen) {
      if (static_cast<std::size_t>(std::popcount(chosen)) != m) continue;
      ++total;
      lower += u_of(chosen) <= u_of(last);
      upper += u_of(chosen) >= u_of(last);
    }
    const RankTest found = mann_whitney(std::span(all).first(n), std::span(all).subspan(n));
    CHECK(found.statistic == u_of(last));
    CHECK(found.p_value == Approx(std::min(1.0, 2 * std::min(lower, upper) / total)));
  }
}

TEST_CASE("Wilcoxon's test has the published critical values") {
  // Two-sided, 5 % (F. Wilcoxon 1945; Hollander and Wolfe, table A.4): the largest significant sum.
  struct Row {
    std::size_t count;
    std::size_t critical;
  };
  for (const Row& row :
       {Row{6, 0}, Row{7, 2}, Row{8, 3}, Row{9, 5}, Row{10, 8}, Row{15, 25}, Row{20, 52}}) {
    const auto p_of = [&](std::size_t sum) {  // positive ranks, largest first, with that sum
      std::vector<double> differences(row.count);
      for (std::size_t rank = row.count; rank > 0; --rank) {
        const bool positive = rank <= sum;
        if (positive) sum -= rank;
        differences[rank - 1] = static_cast<double>(rank) * (positive ? 1 : -1);
      }
      return wilcoxon_signed_rank(differences).p_value;
    };
    INFO(row.count);
    CHECK(p_of(row.critical) <= 0.05);
    CHECK(p_of(row.critical + 1) > 0.05);
  }
  CHECK(wilcoxon_signed_rank(std::vector{0.0, 0.0}).p_value == 1);
}

TEST_CASE("Hollander and Wolfe's depression example") {
  // Table 3.1; R's ?wilcox.test gives V = 40 and a one-sided p of 0.01953; the book's estimate is
  // -0.46 for the difference in the other direction.
  const std::vector<double> before = {1.83, 0.50, 1.62, 2.48, 1.68, 1.88, 1.55, 3.06, 1.30};
  const std::vector<double> after = {0.878, 0.647, 0.598, 2.05, 1.06, 1.29, 1.06, 3.14, 1.29};
  std::vector<double> differences(before.size());
  for (std::size_t at = 0; at < before.size(); ++at) differences[at] = before[at] - after[at];
  const RankTest found = wilcoxon_signed_rank(differences);
  CHECK(found.statistic == 40);
  CHECK(found.p_value == Approx(2 * 0.01953).margin(2e-5));
  const Estimate place = pseudo_median_interval(differences);
  CHECK(place.value == Approx(0.46));
  CHECK(place.low == Approx(0.01));
  CHECK(place.high == Approx(0.786));
}

TEST_CASE("large samples use the normal approximation, and agree with the exact test") {
  std::mt19937_64 random(3);
  std::vector<double> first(30);
  std::vector<double> second(30);
  for (double& value : first) value = static_cast<double>(random() % 1000);
  for (double& value : second) value = static_cast<double>(random() % 1000) + 120;
  const RankTest exact = mann_whitney(first, second);
  const Estimate exact_shift = shift_interval(first, second);
  CHECK(exact.exact);
  // One more value behind everything changes little, and makes the sample too large to count.
  first.push_back(median(first));
  const RankTest approximate = mann_whitney(first, second);
  CHECK_FALSE(approximate.exact);
  CHECK(approximate.p_value == Approx(exact.p_value).margin(2e-4));
  const Estimate shift = shift_interval(first, second);
  CHECK(shift.value == Approx(exact_shift.value).margin(20));
  CHECK(shift.low == Approx(exact_shift.low).margin(30));
  CHECK(shift.high == Approx(exact_shift.high).margin(30));
}

TEST_CASE("the interval of a factor and the rank test say the same") {
  std::mt19937_64 random(5);
  int agree = 0;
  for (int trial = 0; trial < 300; ++trial) {
    std::vector<double> first(7);
    std::vector<double> second(7);
    for (double& value : first) value = 1 + static_cast<double>(random() % 10000) * 1e-4;
    for (double& value : second) value = 1.3 + static_cast<double>(random() % 10000) * 1e-4;
    const Estimate factor = factor_interval(first, second);
    const bool differs = factor.low > 1 || factor.high < 1;
    agree += differs == (mann_whitney(first, second).p_value <= 1 - factor.confidence + 1e-9);
  }
  CHECK(agree == 300);
  const Estimate twice = factor_interval(counted(6), std::vector{2., 4., 6., 8., 10., 12.});
  CHECK(twice.value == Approx(2));
}

TEST_CASE("Benjamini and Hochberg's example") {
  // Their section 3.2: at 5 % the first four of fifteen hypotheses are rejected.
  const std::vector<double> p = {0.0001, 0.0004, 0.0019, 0.0095, 0.0201, 0.0278, 0.0298, 0.0344,
                                 0.0459, 0.3240, 0.4262, 0.5719, 0.6528, 0.7590, 1.0000};
  const std::vector<double> adjusted = adjusted_p_values(p);
  for (std::size_t at = 0; at < p.size(); ++at) CHECK((adjusted[at] <= 0.05) == (at < 4));
  CHECK(adjusted[0] == Approx(0.0015));
  CHECK(adjusted[3] == Approx(0.0095 * 15 / 4));
  CHECK(adjusted[14] == 1);
  CHECK(adjusted_p_values({}).empty());
}

}  // namespace
}  // namespace plait::instrument
