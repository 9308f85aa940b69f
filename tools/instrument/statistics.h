// instrument/statistics.h: statistics of repeated measurements. Times have no known distribution,
// and have outliers upwards, so everything here works on ranks: medians, their intervals by order
// statistics, and rank tests with exact distributions. Nothing is drawn at random.
//
// All functions are pure. REQUIRES: no value is a NaN, and no sample has more than kMostValues
// values. Errors: kInvalidArgument for an empty sample, and for samples that have to be equally
// long.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace plait::instrument {

/// A confidence interval of a shift looks at every pair of values, so samples are bounded.
constexpr std::size_t kMostValues = 2000;

/// The middle value, or the mean of the two middle values.
double median(std::span<const double> values);

/// The value below which `fraction` (0 to 1) of the values lie, linear between order statistics.
/// Source: definition 7 of R. Hyndman, Y. Fan, "Sample quantiles in statistical packages", The
/// American Statistician 50 (1996).
double quantile(std::span<const double> values, double fraction);

/// An estimate and the interval around it.
struct Estimate {
  double value = 0;
  double low = 0, high = 0;
  /// How often such an interval contains the truth. Small samples cannot reach the confidence that
  /// was asked for: the interval is then the widest that the sample gives, and this is less.
  double confidence = 0;
  std::size_t count = 0;  ///< values in the sample; for two samples in the smaller one

  /// Whether the two intervals have a value in common.
  bool overlaps(const Estimate& other) const { return low <= other.high && other.low <= high; }
  /// Half of the interval's width, as a share of the value.
  double relative_half_width() const;
};

/// The median and its interval between the order statistics k and n + 1 - k. k is the largest with
/// P(X < k) <= (1 - confidence) / 2, where X counts heads in n throws of a coin: exact for every
/// distribution. Six values are the fewest for 95 %; five reach 93.75 %.
/// Source: H. David, H. Nagaraja, "Order statistics" (2003), section 7.1.
Estimate median_interval(std::span<const double> values, double confidence = 0.95);

/// The interval of the median of values[i] / floors[i]: pairs were measured in the same round, so
/// that what drifts from round to round cancels. REQUIRES: floors are positive.
Estimate paired_ratio_interval(std::span<const double> values, std::span<const double> floors,
                               double confidence = 0.95);

struct RankTest {
  double statistic = 0;  ///< as each test says
  double p_value = 1;    ///< two-sided; at most 1
  bool exact = true;     ///< false: the normal approximation of large samples
};

/// Mann and Whitney's test of whether values of one sample tend to be larger than those of another.
/// The statistic U counts the pairs in which `second` is larger, ties as half. The distribution is
/// exact with ties too, by counting the subsets of the mid-ranks, up to 60 values together; beyond
/// them it is normal, corrected for ties and for continuity.
/// Sources: H. Mann, D. Whitney, "On a test of whether one of two random variables is
/// stochastically larger than the other", Annals of Mathematical Statistics 18 (1947); the
/// counting: B. Streitberg, J. Roehmel, "Exact distributions for permutation and rank tests",
/// Statistical Software Newsletter 12 (1986).
RankTest mann_whitney(std::span<const double> first, std::span<const double> second);

/// Wilcoxon's signed-rank test of whether differences lie around 0. The statistic is the sum of the
/// ranks of the positive differences; differences of 0 are left out. Exact, with ties too, up to 60
/// differences.
/// Source: F. Wilcoxon, "Individual comparisons by ranking methods", Biometrics Bulletin 1 (1945).
RankTest wilcoxon_signed_rank(std::span<const double> differences);

/// By how much values of `second` are larger than those of `first`: the median of all differences
/// of pairs, and the interval of all shifts that Mann and Whitney's test does not reject. Source:
/// J. Hodges, E. Lehmann, "Estimates of location based on rank tests", Annals of Mathematical
/// Statistics 34 (1963); the interval: D. Bauer, "Constructing confidence sets using rank
/// statistics", Journal of the American Statistical Association 67 (1972).
Estimate shift_interval(std::span<const double> first, std::span<const double> second,
                        double confidence = 0.95);

/// The factor from values of `first` to those of `second`: shift_interval() of their logarithms.
/// 1.10 means "10 % more". REQUIRES: positive values.
Estimate factor_interval(std::span<const double> first, std::span<const double> second,
                         double confidence = 0.95);

/// Where differences lie: the median of the means of all pairs of them (each with itself too), and
/// the interval of all places that Wilcoxon's test does not reject. Sources: as shift_interval().
Estimate pseudo_median_interval(std::span<const double> differences, double confidence = 0.95);

/// Adjusts the p values of several tests: of those that are then at most q, a share of at most q is
/// expected to be wrong, and if there is no difference anywhere, the probability that any is at
/// most q is q at most. The order of the result is that of the argument. Source: Y. Benjamini, Y.
/// Hochberg, "Controlling the false discovery rate", Journal of the Royal Statistical Society B 57
/// (1995).
std::vector<double> adjusted_p_values(std::span<const double> p_values);

}  // namespace plait::instrument
