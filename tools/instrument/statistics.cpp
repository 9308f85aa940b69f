#include "instrument/statistics.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "plait/error.h"

namespace plait::instrument {
namespace {

/// The size up to which two-sample and signed-rank distributions are counted.
constexpr std::size_t kMostExact = 60;

void require_sample(std::span<const double> values) {
  if (values.empty() || values.size() > kMostValues)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("statistics: expected a sample of 1 to {} values, found {}",
                            kMostValues, values.size()));
}

std::vector<double> sorted(std::span<const double> values) {
  require_sample(values);
  std::vector<double> result(values.begin(), values.end());
  std::sort(result.begin(), result.end());
  return result;
}

/// Linear interpolation that gives `low` exactly where the share is 0, even next to an infinity.
double between(double low, double high, double share) {
  if (share <= 0 || low == high) return low;
  return low + (high - low) * share;
}

double quantile_of_sorted(std::span<const double> values, double fraction) {
  const double place = std::clamp(fraction, 0.0, 1.0) * static_cast<double>(values.size() - 1);
  const auto below = static_cast<std::size_t>(place);
  const std::size_t above = std::min(below + 1, values.size() - 1);
  return between(values[below], values[above], place - static_cast<double>(below));
}

double normal_upper_tail(double z) { return std::erfc(z / std::sqrt(2.0)) / 2; }

/// The z with normal_upper_tail(z) = tail, by bisection: it is asked for a few times a report.
double normal_upper_quantile(double tail) {
  double low = 0;
  double high = 40;
  for (int step = 0; step < 100; ++step) {
    const double middle = (low + high) / 2;
    (normal_upper_tail(middle) > tail ? low : high) = middle;
  }
  return low;
}

/// A distribution over 0, 1, ...: probability[i] is that of i.
using Distribution = std::vector<double>;

Distribution scaled(Distribution counts) {
  const double total = std::accumulate(counts.begin(), counts.end(), 0.0);
  for (double& count : counts) count /= total;
  return counts;
}

/// Heads in `throws` throws of a coin. By logarithms, because 2^throws may be beyond a double.
Distribution heads(std::size_t throws) {
  Distribution result(throws + 1);
  const double n = static_cast<double>(throws);
  for (std::size_t at = 0; at <= throws; ++at) {
    const double k = static_cast<double>(at);
    result[at] = std::exp(std::lgamma(n + 1) - std::lgamma(k + 1) - std::lgamma(n - k + 1) -
                          n * std::log(2.0));
  }
  return result;
}

/// Twice the rank of each value of the sorted `values`: equal values have the mean of their ranks,
/// which may be a half.
std::vector<std::size_t> doubled_ranks(std::span<const double> values) {
  std::vector<std::size_t> ranks(values.size());
  for (std::size_t first = 0, next = 0; first < values.size(); first = next) {
    while (next < values.size() && values[next] == values[first]) ++next;
    for (std::size_t at = first; at < next; ++at) ranks[at] = first + next + 1;
  }
  return ranks;
}

/// The sum over groups of equal ranks of t^3 - t, which corrects the variance.
double tie_term(std::span<const std::size_t> ranks) {
  double sum = 0;
  for (std::size_t first = 0, next = 0; first < ranks.size(); first = next) {
    while (next < ranks.size() && ranks[next] == ranks[first]) ++next;
    const double t = static_cast<double>(next - first);
    sum += t * t * t - t;
  }
  return sum;
}

/// The sum of a random subset of `size` of the `ranks`, all subsets equally likely.
Distribution subset_sums(std::span<const std::size_t> ranks, std::size_t size) {
  const std::size_t total = std::accumulate(ranks.begin(), ranks.end(), std::size_t(0));
  std::vector<Distribution> counts(size + 1, Distribution(total + 1, 0.0));
  counts[0][0] = 1;
  for (const std::size_t rank : ranks)
    for (std::size_t chosen = size; chosen > 0; --chosen)
      for (std::size_t sum = total; sum >= rank; --sum)
        counts[chosen][sum] += counts[chosen - 1][sum - rank];
  return scaled(std::move(counts[size]));
}

/// The sum of a random subset of any size.
Distribution any_subset_sums(std::span<const std::size_t> ranks) {
  const std::size_t total = std::accumulate(ranks.begin(), ranks.end(), std::size_t(0));
  Distribution counts(total + 1, 0.0);
  counts[0] = 1;
  for (const std::size_t rank : ranks)
    for (std::size_t sum = total; sum >= rank; --sum) counts[sum] += counts[sum - rank];
  return scaled(std::move(counts));
}

/// Twice the smaller tail at `found`, both with the value itself.
double two_sided(const Distribution& distribution, std::size_t found) {
  double lower = 0;
  double upper = 0;
  for (std::size_t at = 0; at < distribution.size(); ++at) {
    if (at <= found) lower += distribution[at];
    if (at >= found) upper += distribution[at];
  }
  return std::min(1.0, 2 * std::min(lower, upper));
}

double two_sided_normal(double deviation, double continuity, double variance) {
  if (variance <= 0) return 1;
  const double z = std::max(0.0, std::abs(deviation) - continuity) / std::sqrt(variance);
  return std::min(1.0, 2 * normal_upper_tail(z));
}

/// Where an interval begins: order statistic `place`, counted from 0, at this confidence.
struct Cut {
  std::size_t place = 0;
  double confidence = 0;
};

/// The innermost place whose lower tail stays under half of 1 - confidence. `step`: the doubled
/// rank sums of samples without ties are even, so only every second place counts.
Cut cut_of(const Distribution& distribution, std::size_t first, std::size_t step,
           double confidence) {
  const double most = (1 - confidence) / 2 + 1e-12;
  double tail = distribution[first];
  Cut cut{0, 1 - 2 * tail};
  for (std::size_t at = first + step; at < distribution.size(); at += step) {
    tail += distribution[at];
    if (tail > most || tail >= 0.5) break;
    ++cut.place;
    cut.confidence = 1 - 2 * tail;
  }
  return cut;
}

Cut normal_cut(double mean, double variance, double confidence) {
  const double place =
      std::floor(mean - normal_upper_quantile((1 - confidence) / 2) * std::sqrt(variance) - 0.5);
  return {static_cast<std::size_t>(std::max(0.0, place)), confidence};
}

std::vector<std::size_t> ranks_without_ties(std::size_t count) {
  std::vector<std::size_t> ranks(count);
  for (std::size_t at = 0; at < count; ++at) ranks[at] = 2 * (at + 1);
  return ranks;
}

/// The median of `sorted_values`, between the order statistics `cut` from both ends.
Estimate around_median(std::span<const double> sorted_values, const Cut& cut, std::size_t count) {
  const std::size_t place = std::min(cut.place, (sorted_values.size() - 1) / 2);
  return {quantile_of_sorted(sorted_values, 0.5), sorted_values[place],
          sorted_values[sorted_values.size() - 1 - place], std::max(0.0, cut.confidence), count};
}

}  // namespace

double Estimate::relative_half_width() const {
  return value == 0 ? 0 : (high - low) / 2 / std::abs(value);
}

double median(std::span<const double> values) { return quantile(values, 0.5); }

double quantile(std::span<const double> values, double fraction) {
  return quantile_of_sorted(sorted(values), fraction);
}

Estimate median_interval(std::span<const double> values, double confidence) {
  const std::vector<double> ordered = sorted(values);
  return around_median(ordered, cut_of(heads(ordered.size()), 0, 1, confidence), ordered.size());
}

Estimate paired_ratio_interval(std::span<const double> values, std::span<const double> floors,
                               double confidence) {
  if (values.size() != floors.size())
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("statistics: expected a floor for each of {} values, found {}",
                            values.size(), floors.size()));
  std::vector<double> ratios(values.begin(), values.end());
  for (std::size_t at = 0; at < ratios.size(); ++at) ratios[at] /= floors[at];
  return median_interval(ratios, confidence);
}

RankTest mann_whitney(std::span<const double> first, std::span<const double> second) {
  require_sample(first);
  require_sample(second);
  std::vector<double> all(first.begin(), first.end());
  all.insert(all.end(), second.begin(), second.end());
  std::sort(all.begin(), all.end());
  const std::vector<std::size_t> ranks = doubled_ranks(all);
  std::size_t sum = 0;
  for (const double value : second)
    sum += ranks[static_cast<std::size_t>(std::lower_bound(all.begin(), all.end(), value) -
                                          all.begin())];
  const double n = static_cast<double>(first.size());
  const double m = static_cast<double>(second.size());
  RankTest result;
  result.statistic = static_cast<double>(sum) / 2 - m * (m + 1) / 2;
  result.exact = all.size() <= kMostExact;
  if (result.exact) {
    result.p_value = two_sided(subset_sums(ranks, second.size()), sum);
  } else {
    const double both = n + m;
    const double variance = n * m / 12 * (both + 1 - tie_term(ranks) / (both * (both - 1)));
    result.p_value = two_sided_normal(result.statistic - n * m / 2, 0.5, variance);
  }
  return result;
}

RankTest wilcoxon_signed_rank(std::span<const double> differences) {
  std::vector<double> sizes;
  for (const double difference : differences)
    if (difference != 0) sizes.push_back(std::abs(difference));
  if (sizes.empty()) return {};
  require_sample(sizes);
  std::sort(sizes.begin(), sizes.end());
  const std::vector<std::size_t> ranks = doubled_ranks(sizes);
  std::size_t sum = 0;
  for (const double difference : differences)
    if (difference > 0)
      sum += ranks[static_cast<std::size_t>(
          std::lower_bound(sizes.begin(), sizes.end(), difference) - sizes.begin())];
  const double n = static_cast<double>(sizes.size());
  RankTest result;
  result.statistic = static_cast<double>(sum) / 2;
  result.exact = sizes.size() <= kMostExact;
  if (result.exact) {
    result.p_value = two_sided(any_subset_sums(ranks), sum);
  } else {
    const double variance = n * (n + 1) * (2 * n + 1) / 24 - tie_term(ranks) / 48;
    result.p_value = two_sided_normal(result.statistic - n * (n + 1) / 4, 0.5, variance);
  }
  return result;
}

Estimate shift_interval(std::span<const double> first, std::span<const double> second,
                        double confidence) {
  require_sample(first);
  require_sample(second);
  std::vector<double> differences;
  differences.reserve(first.size() * second.size());
  for (const double a : first)
    for (const double b : second) differences.push_back(b - a);
  std::sort(differences.begin(), differences.end());
  const std::size_t together = first.size() + second.size();
  const double pairs = static_cast<double>(differences.size());
  const std::size_t least = second.size() * (second.size() + 1);  // twice the smallest rank sum
  const Cut cut =
      together <= kMostExact
          ? cut_of(subset_sums(ranks_without_ties(together), second.size()), least, 2, confidence)
          : normal_cut(pairs / 2, pairs * static_cast<double>(together + 1) / 12, confidence);
  return around_median(differences, cut, std::min(first.size(), second.size()));
}

Estimate factor_interval(std::span<const double> first, std::span<const double> second,
                         double confidence) {
  std::vector<double> logarithms[2];
  for (const double value : first) logarithms[0].push_back(std::log(value));
  for (const double value : second) logarithms[1].push_back(std::log(value));
  Estimate result = shift_interval(logarithms[0], logarithms[1], confidence);
  result.value = std::exp(result.value);
  result.low = std::exp(result.low);
  result.high = std::exp(result.high);
  return result;
}

Estimate pseudo_median_interval(std::span<const double> differences, double confidence) {
  require_sample(differences);
  std::vector<double> means;
  means.reserve(differences.size() * (differences.size() + 1) / 2);
  for (std::size_t a = 0; a < differences.size(); ++a)
    for (std::size_t b = a; b < differences.size(); ++b)
      means.push_back((differences[a] + differences[b]) / 2);
  std::sort(means.begin(), means.end());
  const double n = static_cast<double>(differences.size());
  const Cut cut =
      differences.size() <= kMostExact
          ? cut_of(any_subset_sums(ranks_without_ties(differences.size())), 0, 2, confidence)
          : normal_cut(n * (n + 1) / 4, n * (n + 1) * (2 * n + 1) / 24, confidence);
  return around_median(means, cut, differences.size());
}

std::vector<double> adjusted_p_values(std::span<const double> p_values) {
  std::vector<std::size_t> order(p_values.size());
  std::iota(order.begin(), order.end(), std::size_t(0));
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return p_values[a] < p_values[b]; });
  std::vector<double> result(p_values.size());
  double least = 1;
  for (std::size_t rank = order.size(); rank > 0; --rank) {
    const double scaled_value =
        p_values[order[rank - 1]] * static_cast<double>(order.size()) / static_cast<double>(rank);
    least = std::min(least, scaled_value);
    result[order[rank - 1]] = least;
  }
  return result;
}

}  // namespace plait::instrument
