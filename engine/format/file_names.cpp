#include "format/file_names.h"

#include <algorithm>
#include <charconv>

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// The text after `prefix`, or nothing if `text` does not begin with it.
std::optional<std::string_view> after(std::string_view prefix, std::string_view text) {
  if (!text.starts_with(prefix)) return std::nullopt;
  return text.substr(prefix.size());
}

bool is_number(std::string_view text) {
  return !text.empty() && std::ranges::all_of(text, [](char c) { return c >= '0' && c <= '9'; });
}

/// Whether the text is "N" or "N.shardI".
bool is_number_of_file(std::string_view text) {
  const std::size_t digits = std::min(text.find('.'), text.size());
  if (!is_number(text.substr(0, digits))) return false;
  const auto shard = after(".shard", text.substr(digits));
  return digits == text.size() || (shard && is_number(*shard));
}

/// N of the name `prefix` + N, as plait writes it.
std::optional<std::uint64_t> version_after(std::string_view prefix, std::string_view name) {
  const auto digits = after(prefix, name);
  if (!digits || !is_number(*digits)) return std::nullopt;
  std::uint64_t version = 0;
  const auto end = digits->data() + digits->size();
  const auto [rest, error] = std::from_chars(digits->data(), end, version);
  if (error != std::errc() || fmt::format("{}{}", prefix, version) != name) return std::nullopt;
  return version;
}

}  // namespace

std::optional<std::uint64_t> version_described_by(std::string_view name) {
  return version_after("version.", name);
}

std::optional<std::uint64_t> change_log_generation(std::string_view name) {
  return version_after("changes.", name);
}

bool is_of_version_alone(std::string_view name, std::uint64_t version) {
  return name == version_file_name(version) ||
         (is_version_file_name(name) && (name.ends_with(fmt::format(".base.{}", version)) ||
                                         name.ends_with(fmt::format(".faces.{}", version))));
}

bool is_bounds_file_name(std::string_view name) {
  const auto rest = after("attribute", name);
  if (!rest) return false;
  const std::size_t digits = std::min(rest->find('.'), rest->size());
  const std::string_view kind = rest->substr(digits);
  return is_number(rest->substr(0, digits)) && (kind == ".bounds" || kind == ".bounds.new");
}

bool is_version_file_name(std::string_view name) {
  if (const auto version = after("version.", name)) return is_number_of_file(*version);
  if (const auto version = after("changes.", name)) return is_number(*version);
  const auto rest = after("attribute", name);
  if (!rest) return false;
  const std::size_t digits = std::min(rest->find('.'), rest->size());
  if (!is_number(rest->substr(0, digits))) return false;
  if (const auto levels = after(".levels.", rest->substr(digits)))
    return levels->find('.') != std::string_view::npos && is_number_of_file(*levels);
  if (const auto level = after(".level", rest->substr(digits)))
    return level->size() > 3 && is_number(level->substr(0, 2)) && (*level)[2] == '.' &&
           is_number_of_file(level->substr(3));
  for (const std::string_view kind : {".base.", ".faces."})
    if (const auto version = after(kind, rest->substr(digits))) return is_number(*version);
  return false;
}

PLAIT_END_NAMESPACE
