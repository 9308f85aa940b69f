#include "instrument/statistics.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <boost/math/special_functions/digamma.hpp>
#include <boost/math/special_functions/polygamma.hpp>
#include <boost/math/special_functions/trigamma.hpp>
#include <cmath>
#include <numeric>
#include <vector>

#include "plait/error.h"

namespace plait::instrument {
namespace {

/// Boost.Math computes in double alone: by default it prepares tables of long double before main(),
/// and where long double is a double (under valgrind) this preparation throws, so that the program
/// cannot start.
using InDouble = boost::math::policies::policy<boost::math::policies::promote_double<false>>;
using StudentsT = boost::math::students_t_distribution<double, InDouble>;

void require_sample(std::span<const double> values) {
  if (values.empty())
    throw Error(ErrorCode::kInvalidArgument, "statistics: expected a sample, found no value");
}

std::vector<double> logarithms(std::span<const double> values) {
  require_sample(values);
  std::vector<double> result(values.begin(), values.end());
  for (double& value : result) value = std::log(value);
  return result;
}

struct Moments {
  double mean = 0, variance = 0;  ///< of a single value
};

Moments moments_of(std::span<const double> values) {
  require_sample(values);
  const auto n = static_cast<double>(values.size());
  Moments found{std::accumulate(values.begin(), values.end(), 0.0) / n, 0};
  if (values.size() < 2) return found;
  for (const double value : values)
    found.variance += (value - found.mean) * (value - found.mean) / (n - 1);
  return found;
}

/// A difference of logarithms with its standard error.
Comparison compared(double difference, double error, double degrees, std::size_t count,
                    double confidence) {
  Comparison found;
  const double factor = std::exp(difference);
  found.factor = {factor, factor, factor, 0, count};
  if (count < 2) return found;
  const double half = error > 0 ? error * student_factor(degrees, confidence) : 0;
  found.factor.low = std::exp(difference - half);
  found.factor.high = std::exp(difference + half);
  found.factor.confidence = confidence;
  if (error > 0)
    found.p_value = 2 * boost::math::cdf(boost::math::complement(StudentsT(degrees),
                                                                 std::abs(difference) / error));
  else
    found.p_value = difference == 0 ? 1 : 0;
  return found;
}

/// The x > 0 with trigamma(x) = y, by Newton's method as in Smyth's appendix.
double inverse_trigamma(double y) {
  double x = 0.5 + 1 / y;
  for (int step = 0; step < 50; ++step) {
    const double here = boost::math::trigamma(x, InDouble());
    const double change = here * (1 - here / y) / boost::math::polygamma(2, x, InDouble());
    x += change;
    if (-change < 1e-8 * x) break;
  }
  return x;
}

}  // namespace

double Estimate::relative_half_width() const {
  return value == 0 ? 0 : (high - low) / 2 / std::abs(value);
}

double median(std::span<const double> values) { return quantile(values, 0.5); }

double quantile(std::span<const double> values, double fraction) {
  require_sample(values);
  std::vector<double> sorted(values.begin(), values.end());
  std::ranges::sort(sorted);
  const double place = std::clamp(fraction, 0.0, 1.0) * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(place);
  const double low = sorted[below], high = sorted[std::min(below + 1, sorted.size() - 1)];
  const double share = place - static_cast<double>(below);
  return share <= 0 || low == high ? low : low + (high - low) * share;
}

double student_factor(double degrees, double confidence) {
  return boost::math::quantile(boost::math::complement(StudentsT(degrees), (1 - confidence) / 2));
}

Estimate mean_interval(std::span<const double> values, double confidence) {
  const Moments found = moments_of(values);
  if (values.size() < 2) return {found.mean, found.mean, found.mean, 0, values.size()};
  const auto n = static_cast<double>(values.size());
  const double half = std::sqrt(found.variance / n) * student_factor(n - 1, confidence);
  return {found.mean, found.mean - half, found.mean + half, confidence, values.size()};
}

Estimate geometric_interval(std::span<const double> values, double confidence) {
  return compare_with_one(values, confidence).factor;
}

Spread common_spread(std::span<const Spread> spreads) {
  constexpr std::size_t kFewest = 4;
  constexpr double kMostDegrees = 20;
  // Logarithms of variances, without what few degrees of freedom add to them.
  std::vector<double> logarithms;
  double noise_of_estimates = 0;
  for (const auto& [variance, degrees] : spreads) {
    if (!(variance > 0) || !(degrees > 0)) continue;
    logarithms.push_back(std::log(variance) - boost::math::digamma(degrees / 2, InDouble()) +
                         std::log(degrees / 2));
    noise_of_estimates += boost::math::trigamma(degrees / 2, InDouble());
  }
  if (logarithms.size() < kFewest) return {};
  const Moments found = moments_of(logarithms);
  const double differences =
      found.variance - noise_of_estimates / static_cast<double>(logarithms.size());
  const double degrees =
      differences > 0 ? std::min(kMostDegrees, 2 * inverse_trigamma(differences)) : kMostDegrees;
  return {
      std::exp(found.mean + boost::math::digamma(degrees / 2, InDouble()) - std::log(degrees / 2)),
      degrees};
}

Comparison compare_paired(std::span<const double> first, std::span<const double> second,
                          double confidence, const Spread& common) {
  if (first.size() != second.size())
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("statistics: expected a partner for each of {} values, found {}",
                            first.size(), second.size()));
  std::vector<double> factors(second.begin(), second.end());
  for (std::size_t at = 0; at < factors.size(); ++at) factors[at] /= first[at];
  return compare_with_one(factors, confidence, common);
}

Comparison compare_with_one(std::span<const double> factors, double confidence,
                            const Spread& common) {
  const Moments found = moments_of(logarithms(factors));
  const auto n = static_cast<double>(factors.size());
  const double degrees = n - 1 + common.degrees;
  const double variance =
      degrees > 0 ? ((n - 1) * found.variance + common.degrees * common.variance) / degrees : 0;
  Comparison result =
      compared(found.mean, std::sqrt(variance / n), degrees, factors.size(), confidence);
  result.spread = std::sqrt(variance);
  return result;
}

Comparison compare_unpaired(std::span<const double> first, std::span<const double> second,
                            double confidence) {
  const Moments a = moments_of(logarithms(first)), b = moments_of(logarithms(second));
  const auto n = static_cast<double>(first.size()), m = static_cast<double>(second.size());
  const double of_a = a.variance / n, of_b = b.variance / m;
  const double degrees =
      of_a + of_b > 0
          ? (of_a + of_b) * (of_a + of_b) /
                (of_a * of_a / std::max(n - 1, 1.0) + of_b * of_b / std::max(m - 1, 1.0))
          : 1;
  Comparison result = compared(b.mean - a.mean, std::sqrt(of_a + of_b), degrees,
                               std::min(first.size(), second.size()), confidence);
  result.spread = std::sqrt(a.variance + b.variance);
  return result;
}

std::vector<double> adjusted_p_values(std::span<const double> p_values) {
  std::vector<std::size_t> order(p_values.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, [&](auto a, auto b) { return p_values[a] < p_values[b]; });
  std::vector<double> adjusted(p_values.size());
  double least = 1;
  for (std::size_t rank = order.size(); rank > 0; --rank) {
    const std::size_t at = order[rank - 1];
    least = std::min(
        least, p_values[at] * static_cast<double>(p_values.size()) / static_cast<double>(rank));
    adjusted[at] = least;
  }
  return adjusted;
}

double confidence_among(std::span<const double> p_values, double q) {
  const auto shown = std::ranges::count_if(adjusted_p_values(p_values),
                                           [&](double adjusted) { return adjusted <= q; });
  const double all = std::max(1.0, static_cast<double>(p_values.size()));
  return 1 - q * std::max(1.0, static_cast<double>(shown)) / all;
}

}  // namespace plait::instrument
