// plait/extend/rounding.h: lossy attributes. Their numbers are rounded to the multiples of a step
// before they are stored, so that each record stays within a bound of what it was. All that comes
// after is lossless: digests, checksums and copies are those of the rounded records.
//
// The step follows from the bound and from the base records, which are not rounded. So rounding the
// result once more with the same bound changes nothing. What the step cannot round within the bound
// stays as it is: NaN, infinities, -0, and numbers whose spacing is larger than half the step.
//
//   ErrorBounds bounds;
//   bounds.add("1e-5");                       // positions, in the model's units
//   bounds.add("normal=1e-3,euclidean");
//
// Pinned by tests/engine/base/rounding_test.cpp, with an oracle in long double.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "plait/attribute.h"
#include "plait/detail/namespace.h"

PLAIT_BEGIN_NAMESPACE

/// Stored: never renumber.
enum class ErrorMetric : std::uint8_t {
  kComponent = 1,  ///< the largest difference of a component
  kEuclidean = 2,  ///< the length of the difference of two records
};
std::string_view to_string(ErrorMetric metric) noexcept;

/// How an attribute was rounded. A version of a store records it for each such attribute. Lengths
/// are in the attribute's own units. If an attribute is rounded with several bounds, one after
/// another, `bound` and the errors found are sums: bounds of the error against the first records.
struct Rounding {
  ErrorMetric metric = ErrorMetric::kComponent;
  double bound = 0;          ///< no error is larger
  double step = 0;           ///< of the last rounding
  double largest_error = 0;  ///< found
  double rms_error = 0;      ///< found: root of the mean of the squares, over all records but base
                             ///< records; or over all their components, by `metric`

  friend bool operator==(const Rounding&, const Rounding&) = default;
};

/// What a user asks for.
struct ErrorBound {
  double value = 0;
  bool relative = false;  ///< in diagonals of the bounding box of the base records
  ErrorMetric metric = ErrorMetric::kComponent;

  /// "1e-5", "1e-6rel", and either with ",component" or ",euclidean". Errors: kInvalidArgument.
  static ErrorBound parse(std::string_view text);
};

/// The bounds of the attributes of a store.
class ErrorBounds {
 public:
  /// `text` is a bound for "position", or "ATTRIBUTE=BOUND". A later text for the same attribute
  /// takes the place of the earlier one. Errors: kInvalidArgument.
  void add(std::string_view text);
  bool empty() const { return bounds_.empty(); }
  /// The bound of an attribute; nothing if no text names it.
  std::optional<ErrorBound> of(std::string_view attribute) const;
  const std::map<std::string, ErrorBound, std::less<>>& all() const { return bounds_; }

 private:
  std::map<std::string, ErrorBound, std::less<>> bounds_;
};

/// Rounds the records of one attribute, and measures the errors. For one thread.
class Rounder {
 public:
  /// `base_records` are those of the attribute. Errors: kNotSupported unless the components are
  /// float32 or float64, and if the step would be outside of kLeastStep to kMostStep
  /// (base/number_lattice.h); kInvalidArgument for a relative bound if the base records have no
  /// box of finite extent.
  Rounder(const AttributeSchema& schema, const ErrorBound& bound,
          std::span<const std::byte> base_records);
  ~Rounder();
  Rounder(Rounder&&) noexcept;
  Rounder& operator=(Rounder&&) noexcept;

  struct Work;  ///< inside the library

  double step() const noexcept { return result_.step; }
  /// Rounds whole records in place. The order of the calls changes nothing but the last bits of
  /// `rms_error`.
  void round(std::span<std::byte> records);
  /// With the errors of all calls so far. `earlier` is the rounding of the records before.
  Rounding result(const std::optional<Rounding>& earlier = {}) const;

 private:
  std::unique_ptr<Work> work_;
  Rounding result_;
  std::uint32_t components_;
};

PLAIT_END_NAMESPACE
