#include "store/file_names.h"

#include <algorithm>
#include <optional>

namespace plait {
namespace {

/// What is behind `prefix`.
std::optional<std::string_view> after(std::string_view prefix, std::string_view text) {
  if (!text.starts_with(prefix)) return std::nullopt;
  return text.substr(prefix.size());
}

bool is_number(std::string_view text) {
  return !text.empty() && std::ranges::all_of(text, [](char c) { return c >= '0' && c <= '9'; });
}

}  // namespace

bool is_version_file_name(std::string_view name) {
  if (const auto version = after("tables.", name)) return is_number(*version);
  const auto rest = after("attribute", name);
  if (!rest) return false;
  const std::size_t digits = std::min(rest->find('.'), rest->size());
  if (!is_number(rest->substr(0, digits))) return false;
  if (const auto level = after(".level", rest->substr(digits)))
    return is_number(*level) && level->size() == 2;
  const auto version = after(".base.", rest->substr(digits));
  return version && is_number(*version);
}

}  // namespace plait
