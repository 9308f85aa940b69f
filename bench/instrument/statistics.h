// bench/instrument/statistics.h: statistics of repeated measurements. Times are compared by their
// logarithms: noise is a share of a time, and a difference is a factor. What drifts from round to
// round cancels where two things were measured in the same rounds. There is one interval,
// Student's: it holds for two values as for twenty, and an outlier widens it, so that it hides a
// difference rather than making one. Where there are many comparisons, their noise in common
// narrows the intervals of few values. Nothing is drawn at random.
//
// All functions are pure. REQUIRES: no value is a NaN; values of which logarithms are taken are
// positive. Errors: kInvalidArgument for an empty sample, and for samples that have to be equally
// long.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace plait::instrument {

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
  double confidence =
      0;  ///< how often such an interval contains the truth; 0: there is no interval
  std::size_t count = 0;  ///< values in the sample; for two samples in the smaller one

  /// Half of the interval's width, as a share of the value.
  double relative_half_width() const;
};

/// The factor of Student's interval: its half width over the standard error. REQUIRES: degrees > 0,
/// 0 < confidence < 1.
double student_factor(double degrees, double confidence);

/// The mean. A single value has no interval: low and high are the value, and the confidence is 0.
/// Source: Student, "The probable error of a mean", Biometrika 6 (1908).
Estimate mean_interval(std::span<const double> values, double confidence = 0.95);

/// The geometric mean: mean_interval() of the logarithms.
Estimate geometric_interval(std::span<const double> values, double confidence = 0.95);

/// What a comparison found: by which factor the second of two takes longer. 1.10 is "10 % more".
struct Comparison {
  Estimate factor;
  double p_value = 1;  ///< two-sided, that there is no difference; 1 if nothing says how sure it is
  double spread = 0;   ///< the standard deviation of the logarithms of a single pair's factors
};

/// A variance of logarithms, and the degrees of freedom that it was estimated with.
struct Spread {
  double variance = 0, degrees = 0;
};

/// What several comparisons have in common: how noisy pairs are on the whole, and how many degrees
/// of freedom that is worth for each of them, 0 to 20: many if they are about equally noisy, none
/// if they differ much, or if there are fewer than four. Spreads without variance or degrees do not
/// count. Source: G. Smyth, "Linear models and empirical Bayes methods for assessing differential
/// expression in microarray experiments", Statistical Applications in Genetics and Molecular
/// Biology 3 (2004), section 6.2. Pinned by tests/bench/instrument/statistics_test.cpp.
Spread common_spread(std::span<const Spread> spreads);

/// first[i] and second[i] were measured in the same round. The variance is that of their factors
/// and `common`, each weighted with its degrees of freedom.
Comparison compare_paired(std::span<const double> first, std::span<const double> second,
                          double confidence = 0.95, const Spread& common = {});

/// The samples have nothing in common, and may have different spreads. Source: B. Welch, "The
/// generalization of Student's problem when several different population variances are involved",
/// Biometrika 34 (1947).
Comparison compare_unpaired(std::span<const double> first, std::span<const double> second,
                            double confidence = 0.95);

/// Whether factors are 1 on the whole: compare_paired() of each with 1.
Comparison compare_with_one(std::span<const double> factors, double confidence = 0.95,
                            const Spread& common = {});

/// Adjusts the p values of several tests: of those that are then at most q, a share of at most q is
/// expected to be wrong, and if there is no difference anywhere, the probability that any is at
/// most q is q at most. The order of the result is that of the argument. Source: Y. Benjamini, Y.
/// Hochberg, "Controlling the false discovery rate", Journal of the Royal Statistical Society B 57
/// (1995).
std::vector<double> adjusted_p_values(std::span<const double> p_values);

/// The confidence of intervals that say the same as adjusted_p_values() at `q`: those of
/// differences that are shown exclude 1, and a share of at most q of these misses the truth.
/// Source: Y. Benjamini, D. Yekutieli, "False discovery rate-adjusted multiple confidence intervals
/// for selected parameters", Journal of the American Statistical Association 100 (2005).
double confidence_among(std::span<const double> p_values, double q);

}  // namespace plait::instrument
