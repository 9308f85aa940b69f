#include "tune/figures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace plait::tune {
namespace {

/// The factor of a 95 % interval from n samples: quantile 0.975 of Student's distribution.
double student_factor(std::size_t samples) {
  constexpr std::array kOfDegrees = {12.71, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306,
                                     2.262, 2.228, 2.201, 2.179, 2.160, 2.145, 2.131};
  const std::size_t degrees = samples - 1;
  return degrees <= kOfDegrees.size() ? kOfDegrees[degrees - 1] : 2.0;
}

/// The parts that count for a trial.
std::vector<std::size_t> parts_of(const Trials& trials, const Trial& trial) {
  std::vector<std::size_t> parts = common_parts(trials, trial.attribute);
  if (!parts.empty()) return parts;
  for (std::size_t part = 0; part < trial.outcomes.size(); ++part)
    if (trial.outcomes[part].visits > 0) parts.push_back(part);
  return parts;
}

}  // namespace

bool is_measured(const Trial& trial) {
  return std::ranges::any_of(trial.outcomes, [](const Outcome& part) { return part.visits > 0; });
}

std::vector<std::size_t> common_parts(const Trials& trials, std::size_t attribute) {
  std::vector<std::size_t> parts;
  for (std::size_t part = 0; part < trials.attributes[attribute].parts; ++part)
    if (std::ranges::all_of(trials.trials, [&](const Trial& trial) {
          return trial.attribute != attribute || trial.outcomes[part].visits > 0;
        }))
      parts.push_back(part);
  return parts;
}

Figure ratio_of_sums(const std::vector<double>& x, const std::vector<double>& y, bool is_whole) {
  double sum_x = 0, sum_y = 0;
  for (const double value : x) sum_x += value;
  for (const double value : y) sum_y += value;
  const double ratio = sum_y / sum_x;
  if (is_whole) return {ratio, ratio, ratio};
  const std::size_t count = x.size();
  if (count < 2) return {ratio, 0, std::numeric_limits<double>::infinity()};
  double squares = 0;
  for (std::size_t i = 0; i < count; ++i) squares += (y[i] - ratio * x[i]) * (y[i] - ratio * x[i]);
  const auto n = static_cast<double>(count);
  const double error = std::sqrt(squares / (n * (n - 1))) / (sum_x / n) * student_factor(count);
  return {ratio, std::max(0.0, ratio - error), ratio + error};
}

Figure mean_of_ratios(const std::vector<double>& x, const std::vector<double>& y) {
  const auto n = static_cast<double>(x.size());
  double sum = 0, squares = 0;
  for (std::size_t i = 0; i < x.size(); ++i) sum += y[i] / x[i];
  const double mean = sum / n;
  if (x.size() < 2) return {mean, 0, std::numeric_limits<double>::infinity()};
  for (std::size_t i = 0; i < x.size(); ++i) squares += (y[i] / x[i] - mean) * (y[i] / x[i] - mean);
  const double error = std::sqrt(squares / (n * (n - 1))) * student_factor(x.size());
  return {mean, std::max(0.0, mean - error), mean + error};
}

Rates rates_of(const Trials& trials, const Trial& trial, std::optional<std::size_t> without) {
  std::vector<double> raw, stored, encode, decode;
  std::vector<std::size_t> parts = parts_of(trials, trial);
  if (without && *without < parts.size() && parts.size() > 1)
    parts.erase(parts.begin() + static_cast<std::ptrdiff_t>(*without));
  for (const std::size_t part : parts) {
    raw.push_back(trial.outcomes[part].raw_bytes);
    stored.push_back(trial.outcomes[part].stored_bytes);
    encode.push_back(trial.outcomes[part].encode_seconds);
    decode.push_back(trial.outcomes[part].decode_seconds);
  }
  const SampledAttribute& attribute = trials.attributes[trial.attribute];
  if (!attribute.is_whole)
    return {mean_of_ratios(raw, stored), mean_of_ratios(raw, encode), mean_of_ratios(raw, decode)};
  return {ratio_of_sums(raw, stored, raw.size() == attribute.parts),
          ratio_of_sums(raw, encode, false), ratio_of_sums(raw, decode, false)};
}

}  // namespace plait::tune
