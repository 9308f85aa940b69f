// The texts that name bounds, such as "normal=1e-3,euclidean".
#include <fmt/format.h>

#include <charconv>
#include <cmath>

#include "plait/error.h"
#include "plait/extend/rounding.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

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
