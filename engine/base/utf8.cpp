#include "base/utf8.h"

#include <cstddef>
#include <cstdint>

PLAIT_BEGIN_PRIVATE_NAMESPACE

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

PLAIT_END_NAMESPACE
