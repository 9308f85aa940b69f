#include "plait/extend/rounding.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include "base/default_arithmetic.h"
#include "base/number_lattice.h"
#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// The extent of the finite components of records.
struct Extent {
  double largest = 0;   ///< of all magnitudes
  double diagonal = 0;  ///< of the box
};

template <class Number>
Extent extent_of(std::span<const std::byte> bytes, std::uint32_t components) {
  Extent extent;
  for (std::uint32_t component = 0; component < components; ++component) {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (std::size_t at = component * sizeof(Number); at < bytes.size();
         at += components * sizeof(Number)) {
      Number number;
      std::memcpy(&number, bytes.data() + at, sizeof number);
      if (!std::isfinite(number)) continue;
      extent.largest = std::max(extent.largest, std::abs(static_cast<double>(number)));
      low = std::min(low, static_cast<double>(number));
      high = std::max(high, static_cast<double>(number));
    }
    if (low <= high) extent.diagonal = std::hypot(extent.diagonal, high - low);
  }
  return extent;
}

/// The spacing of numbers below the power of two above `largest`: rounding to the type moves a
/// number by half of it at most.
double spacing_below_power_above(double largest, int digits) {
  if (!(largest > 0)) return 0;
  int exponent = 0;
  std::frexp(largest, &exponent);  // largest < 2^exponent
  return std::ldexp(1.0, exponent - digits);
}

/// Half a step and half a spacing are within the bound of a component. If floats are spaced more
/// widely than the bound allows, the step does not become small for them: numbers that rounding
/// would move too far keep their bits.
double step_for(double bound, double spacing) {
  constexpr double kForRoundingOfTheseLines = 1 - 0x1p-20;
  return (2 * bound - std::min(spacing, bound / 2)) * kForRoundingOfTheseLines;
}

}  // namespace

/// The loops for one type of numbers.
struct Rounder::Work {
  virtual ~Work() = default;
  virtual void round(std::span<std::byte> records) = 0;

  double largest_found = 0;  ///< error; for records its square
  double squares_found = 0;  ///< sum over all components
  std::uint64_t records_done = 0;
};

namespace {

template <class Number>
class WorkOf final : public Rounder::Work {
 public:
  WorkOf(double step, double bound, ErrorMetric metric, std::uint32_t components)
      : lattice_(step), bound_(bound), metric_(metric), components_(components) {}

  void round(std::span<std::byte> bytes) override {
    const DefaultArithmetic arithmetic;
    metric_ == ErrorMetric::kComponent ? round_numbers(bytes) : round_records(bytes);
  }

 private:
  /// The nearest number of the lattice; x itself if there is none within the bound, and for -0.
  [[gnu::always_inline]] Number rounded(Number x) const noexcept {
    const auto nearest = lattice_.nearest(x);
    const Number to = lattice_.number(nearest.exists ? nearest.index : 0);
    // The difference is exact: both numbers are within a factor of two of each other, or one is 0.
    const double error = std::abs(static_cast<double>(x) - static_cast<double>(to));
    const bool keeps = !nearest.exists | !(error <= bound_) | (x == 0);
    return keeps ? x : to;
  }

  [[gnu::noinline]] void round_numbers(std::span<std::byte> bytes) noexcept {
    auto* __restrict const numbers = reinterpret_cast<Number*>(bytes.data());
    const std::size_t count = bytes.size() / sizeof(Number);
    // Several sums, so that the loop can be a vector loop. Their order is fixed.
    constexpr std::size_t kSums = 4;
    double largest[kSums] = {}, squares[kSums] = {};
    std::size_t at = 0;
    const auto take = [&](std::size_t number, std::size_t sum) {
      const Number x = numbers[number], to = rounded(x);
      const double error = std::abs(static_cast<double>(x) - static_cast<double>(to));
      const double counted = error <= bound_ ? error : 0;  // what is no number keeps its bits
      largest[sum] = counted > largest[sum] ? counted : largest[sum];
      squares[sum] += counted * counted;
      numbers[number] = to;
    };
    for (; at + kSums <= count; at += kSums)
      for (std::size_t sum = 0; sum < kSums; ++sum) take(at + sum, sum);
    for (; at < count; ++at) take(at, 0);
    for (std::size_t sum = 0; sum < kSums; ++sum) {
      largest_found = std::max(largest_found, largest[sum]);
      squares_found += squares[sum];
    }
    records_done += count / components_;
  }

  [[gnu::noinline]] void round_records(std::span<std::byte> bytes) noexcept {
    auto* const numbers = reinterpret_cast<Number*>(bytes.data());
    const std::size_t count = bytes.size() / sizeof(Number);
    // The sum of squares is rounded, so the bound is a little smaller than its square.
    const double most = bound_ * bound_ * (1 - 0x1p-40);
    std::vector<Number>& to = rounded_;
    to.resize(components_);
    for (std::size_t first = 0; first + components_ <= count; first += components_) {
      double sum = 0;
      for (std::uint32_t i = 0; i < components_; ++i) {
        const Number x = numbers[first + i];
        to[i] = rounded(x);
        const double error = static_cast<double>(x) - static_cast<double>(to[i]);
        sum += error == error ? error * error : 0;
      }
      ++records_done;
      if (!(sum <= most)) continue;
      std::copy(to.begin(), to.end(), numbers + first);
      largest_found = std::max(largest_found, sum);
      squares_found += sum;
    }
  }

  NumberLattice<Number> lattice_;
  double bound_;
  ErrorMetric metric_;
  std::uint32_t components_;
  std::vector<Number> rounded_;
};

}  // namespace

Rounder::Rounder(const AttributeSchema& schema, const ErrorBound& bound,
                 std::span<const std::byte> base_records)
    : components_(schema.components) {
  const DefaultArithmetic arithmetic;
  const auto refuse = [&](ErrorCode code, const std::string& reason) {
    return Error(code, fmt::format("round attribute '{}': {}", schema.name, reason));
  };
  const bool narrow = schema.type == ComponentType::kFloat32;
  if (!narrow && schema.type != ComponentType::kFloat64)
    throw refuse(ErrorCode::kNotSupported,
                 fmt::format("expected float32 or float64, found {}", to_string(schema.type)));
  const Extent extent = narrow ? extent_of<float>(base_records, components_)
                               : extent_of<double>(base_records, components_);
  result_.metric = bound.metric;
  result_.bound = bound.relative ? bound.value * extent.diagonal : bound.value;
  if (!(result_.bound > 0) || !std::isfinite(result_.bound))
    throw refuse(ErrorCode::kInvalidArgument,
                 fmt::format("expected a bounding box of the base records with a diagonal above 0, "
                             "found {:g}",
                             extent.diagonal));
  const double of_component = bound.metric == ErrorMetric::kEuclidean
                                  ? result_.bound / std::sqrt(static_cast<double>(components_))
                                  : result_.bound;
  const int digits =
      narrow ? std::numeric_limits<float>::digits : std::numeric_limits<double>::digits;
  result_.step = step_for(of_component, spacing_below_power_above(extent.largest, digits));
  if (!(result_.step >= kLeastStep && result_.step <= kMostStep))
    throw refuse(ErrorCode::kNotSupported,
                 fmt::format("expected a bound from {:g} to {:g}, found {:g}", kLeastStep,
                             kMostStep / 2, result_.bound));
  if (narrow)
    work_ = std::make_unique<WorkOf<float>>(result_.step, result_.bound, bound.metric, components_);
  else
    work_ =
        std::make_unique<WorkOf<double>>(result_.step, result_.bound, bound.metric, components_);
}

Rounder::~Rounder() = default;
Rounder::Rounder(Rounder&&) noexcept = default;
Rounder& Rounder::operator=(Rounder&&) noexcept = default;

void Rounder::round(std::span<std::byte> records) { work_->round(records); }

Rounding Rounder::result(const std::optional<Rounding>& earlier) const {
  const DefaultArithmetic arithmetic;
  const bool euclidean = result_.metric == ErrorMetric::kEuclidean;
  Rounding result = result_;
  // A root is rounded to nearest; the next number above it is not below the exact root.
  const double root = std::sqrt(work_->largest_found);
  result.largest_error = !euclidean  ? work_->largest_found
                         : root == 0 ? 0
                                     : std::min(std::nextafter(root, result.bound), result.bound);
  const double count = static_cast<double>(work_->records_done) *
                       (euclidean ? 1.0 : static_cast<double>(components_));
  result.rms_error = count > 0 ? std::sqrt(work_->squares_found / count) : 0;
  if (!earlier) return result;
  if (result.largest_error == 0) {
    Rounding same = *earlier;
    same.step = result.step;
    return same;
  }
  // The longest difference of records whose components differ by 1 at most.
  const double longer = euclidean && earlier->metric == ErrorMetric::kComponent
                            ? std::sqrt(static_cast<double>(components_))
                            : 1.0;
  result.bound += longer * earlier->bound;
  result.largest_error += longer * earlier->largest_error;
  result.rms_error += longer * earlier->rms_error;
  return result;
}

// The texts that name bounds, such as "normal=1e-3,euclidean".

std::string_view to_string(ErrorMetric metric) noexcept {
  return metric == ErrorMetric::kEuclidean ? "euclidean" : "component";
}

ErrorBound ErrorBound::parse(std::string_view text) {
  const auto refuse = [text](std::string_view reason) {
    return Error(ErrorCode::kInvalidArgument,
                 fmt::format("choose an error bound: expected a number above 0 such as 1e-5, or "
                             "1e-6rel, with or without \",component\" or \",euclidean\", found "
                             "\"{}\"{}",
                             text, reason));
  };
  ErrorBound bound;
  const std::size_t comma = text.find(',');
  if (comma != std::string_view::npos) {
    const std::string_view metric = text.substr(comma + 1);
    if (metric == to_string(ErrorMetric::kEuclidean))
      bound.metric = ErrorMetric::kEuclidean;
    else if (metric != to_string(ErrorMetric::kComponent))
      throw refuse("");
  }
  const std::string_view number = text.substr(0, comma);
  const char* const end = number.data() + number.size();
  const auto [after, error] = std::from_chars(number.data(), end, bound.value);
  if (error == std::errc::invalid_argument) throw refuse("");
  const std::string_view unit(after, static_cast<std::size_t>(end - after));
  if (!unit.empty() && unit != "rel") throw refuse("");
  bound.relative = !unit.empty();
  if (error != std::errc() || !std::isfinite(bound.value) || !(bound.value > 0))
    throw refuse(", which is no such number");
  return bound;
}

void ErrorBounds::add(std::string_view text) {
  const std::size_t equals = text.find('=');
  const std::string_view attribute =
      equals == std::string_view::npos ? std::string_view("position") : text.substr(0, equals);
  if (attribute.empty())
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("choose an error bound: expected BOUND or ATTRIBUTE=BOUND, found "
                            "\"{}\"",
                            text));
  const std::string_view bound = equals == std::string_view::npos ? text : text.substr(equals + 1);
  bounds_.insert_or_assign(std::string(attribute), ErrorBound::parse(bound));
}

std::optional<ErrorBound> ErrorBounds::of(std::string_view attribute) const {
  const auto found = bounds_.find(attribute);
  return found == bounds_.end() ? std::nullopt : std::optional(found->second);
}

PLAIT_END_NAMESPACE
