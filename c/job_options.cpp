#include "job_options.h"

#include "guard.h"

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

std::function<void(const std::string&)> warnings_by(plait_warning warn, void* user) {
  if (warn == nullptr) return {};
  return [warn, user](const std::string& text) { warn(text.c_str(), user); };
}

}  // namespace plait::c
