#include "job_options.h"

#include <fmt/format.h>

#include "guard.h"
#include "plait/error.h"

namespace plait::c {
namespace {

/// Calls add(text) for each text.
template <class Add>
void for_each_text(const char* const* texts, std::uint64_t count, const char* argument, Add add) {
  if (count > 0) check_given(texts, argument);
  for (std::uint64_t at = 0; at < count; ++at) {
    check_given(texts[at], argument);
    add(texts[at]);
  }
}

}  // namespace

Compression compression_of(const char* const* texts, std::uint64_t count) {
  Compression compression;
  for_each_text(texts, count, "compress", [&](const char* text) { compression.add(text); });
  return compression;
}

ErrorBounds bounds_of(const char* const* texts, std::uint64_t count) {
  ErrorBounds bounds;
  for_each_text(texts, count, "max_errors", [&](const char* text) { bounds.add(text); });
  return bounds;
}

std::optional<double> weld_of(std::int32_t weld, double tolerance) {
  check_choice("weld", weld, 2);
  if (weld == 0 && tolerance != 0)
    throw Error(
        ErrorCode::kInvalidArgument,
        fmt::format("weld_tolerance: expected weld = 1 with it, found {} and no weld", tolerance));
  return weld != 0 ? std::optional(tolerance) : std::nullopt;
}

std::optional<ComponentType> precision_of(plait_component_type precision) {
  if (precision == 0) return std::nullopt;
  if (precision != PLAIT_FLOAT32 && precision != PLAIT_FLOAT64)
    throw Error(
        ErrorCode::kInvalidArgument,
        fmt::format("precision: expected PLAIT_FLOAT32 or PLAIT_FLOAT64, found {}", precision));
  return static_cast<ComponentType>(precision);
}

std::function<void(const std::string&)> warnings_by(plait_warning warn, void* user) {
  if (warn == nullptr) return {};
  return [warn, user](const std::string& text) { warn(text.c_str(), user); };
}

}  // namespace plait::c
