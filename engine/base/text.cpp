#include "base/text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <utility>

PLAIT_BEGIN_PRIVATE_NAMESPACE

std::string format_bytes(std::uint64_t bytes) {
  if (bytes < 1024) return fmt::format("{} bytes", bytes);
  constexpr const char* kUnits[] = {"KiB", "MiB", "GiB", "TiB", "PiB", "EiB"};
  double value = static_cast<double>(bytes) / 1024;
  std::size_t unit = 0;
  for (; value >= 1024 && unit + 1 < std::size(kUnits); ++unit) value /= 1024;
  return fmt::format("{:.{}f} {}", value, value < 10 ? 2 : value < 100 ? 1 : 0, kUnits[unit]);
}

std::string size_text(std::uint64_t bytes) {
  constexpr std::pair<int, const char*> kUnits[] = {
      {40, "TiB"}, {30, "GiB"}, {20, "MiB"}, {10, "KiB"}};
  for (const auto& [shift, unit] : kUnits)
    if (bytes != 0 && (bytes & ((std::uint64_t{1} << shift) - 1)) == 0)
      return fmt::format("{}{}", bytes >> shift, unit);
  return std::to_string(bytes);
}

std::string lower_extension(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::ranges::transform(extension, extension.begin(), [](char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c;
  });
  return extension;
}

std::string text_for_message(std::string_view text) {
  std::string shown(text.substr(0, 100));
  std::ranges::replace_if(
      shown, [](char c) { return c < ' ' || c > '~'; }, '?');
  return shown;
}

bool is_utf8_text(std::string_view text) noexcept {
  for (std::size_t at = 0; at < text.size();) {
    const auto first = static_cast<std::uint8_t>(text[at++]);
    if (first < 0x80) {
      if ((first < 0x20 && first != '\t' && first != '\n') || first == 0x7f) return false;
      continue;
    }
    if (first < 0xc2 || first > 0xf4) return false;
    const std::size_t more = first < 0xe0 ? 1 : first < 0xf0 ? 2 : 3;
    std::uint32_t point = first & (0x3fu >> more);
    for (std::size_t byte = 0; byte < more; ++byte, ++at) {
      const auto next = at < text.size() ? static_cast<std::uint8_t>(text[at]) : 0u;
      if ((next & 0xc0u) != 0x80u) return false;
      point = point << 6 | (next & 0x3fu);
    }
    constexpr std::uint32_t kLeast[] = {0x80, 0x800, 0x10000};
    const bool surrogate = point >= 0xd800 && point <= 0xdfff;
    // Control characters of ISO 8859, in two bytes.
    if (point < kLeast[more - 1] || point > 0x10ffff || surrogate || point < 0xa0) return false;
  }
  return true;
}

namespace {

/// The most characters of a name in a message, because a message is one line.
constexpr std::size_t kMostOfAName = 100;

}  // namespace

std::string join_names(std::span<const std::string_view> names) {
  return fmt::format("{}", fmt::join(names, ", "));
}

Error unknown_name(std::string_view what, std::string_view name,
                   std::span<const std::string_view> names) {
  return Error(ErrorCode::kInvalidArgument,
               fmt::format("unknown {} '{}', expected {}", what, name.substr(0, kMostOfAName),
                           join_names(names)));
}

PLAIT_END_NAMESPACE
