// The codec `bitpack`: each group of 16 words of 32 bits in as many bits a word as its largest word
// needs. It suits filters that leave small numbers. docs/filters/bitpack.md has the bytes.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <numeric>
#include <vector>

#include "compressed/codecs/built_in_codecs.h"
#include "compressed/codecs/packed_groups.h"
#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr std::size_t kWordBytes = sizeof(std::uint32_t);
constexpr std::size_t kGroupBytes = kGroupWords * kWordBytes;
using GroupBytes = std::array<std::byte, kGroupBytes>;
/// The width of a width of at most 32.
constexpr std::uint32_t kMostBitsOfWidths = 6;

constexpr std::size_t groups_of(std::size_t words) {
  return (words + kGroupWords - 1) / kGroupWords;
}

/// How a block is cut.
struct Cut {
  std::size_t whole;       ///< groups of 16 words
  std::size_t last_words;  ///< of the group after them, which has fewer; 0: there is none
  std::size_t bytes;       ///< at the end, which are no word

  explicit Cut(std::size_t raw_bytes)
      : whole(raw_bytes / kGroupBytes),
        last_words(raw_bytes % kGroupBytes / kWordBytes),
        bytes(raw_bytes % kWordBytes) {}
  std::size_t groups() const { return whole + (last_words > 0 ? 1 : 0); }
  /// The widths are words, and packed in groups too.
  std::size_t width_groups() const { return groups_of(groups()); }
};

std::size_t sum(std::span<const std::uint32_t> widths) {
  return std::accumulate(widths.begin(), widths.end(), std::size_t{0});
}

class BitpackCodec final : public Codec {
 public:
  std::size_t bound(std::size_t raw_bytes) const override {
    const std::size_t width_groups = Cut(raw_bytes).width_groups();
    return width_groups * (1 + packed_bytes(kGroupWords, kMostBitsOfWidths)) + raw_bytes;
  }
  std::size_t memory_bytes(std::size_t raw_bytes) const override {
    const std::size_t width_groups = Cut(raw_bytes).width_groups();
    return width_groups * (kGroupWords + 1) * kWordBytes;
  }

  std::optional<std::size_t> compress(std::span<const std::byte> raw,
                                      std::span<std::byte> into) override {
    const Cut cut(raw.size());
    make_room(cut);
    GroupBytes last{};
    std::ranges::copy(raw.subspan(cut.whole * kGroupBytes, cut.last_words * kWordBytes),
                      last.begin());
    find_widths(raw.data(), cut.whole, widths_.data());
    if (cut.last_words > 0) find_widths(last.data(), 1, &widths_[cut.whole]);
    const auto widths = std::as_bytes(std::span(widths_));
    find_widths(widths.data(), cut.width_groups(), widths_of_widths_.data());

    const Sizes sizes(*this, cut);
    if (sizes.all() > into.size()) return std::nullopt;
    std::ranges::transform(widths_of_widths_, into.begin(),
                           [](std::uint32_t width) { return static_cast<std::byte>(width); });
    into = into.subspan(cut.width_groups());
    pack_groups(widths.data(), cut.width_groups(), widths_of_widths_.data(), into.data());
    into = into.subspan(sizes.widths);
    pack_groups(raw.data(), cut.whole, widths_.data(), into.data());
    into = into.subspan(sizes.whole);
    if (cut.last_words > 0) {
      GroupBytes packed;
      pack_groups(last.data(), 1, &widths_[cut.whole], packed.data());
      std::copy_n(packed.begin(), sizes.last, into.begin());
    }
    std::ranges::copy(raw.last(cut.bytes), into.subspan(sizes.last).begin());
    return sizes.all();
  }

  void decompress(std::span<const std::byte> stored, std::span<std::byte> raw) override {
    const Cut cut(raw.size());
    make_room(cut);
    const std::size_t found = stored.size();
    expect_at_least(cut.width_groups(), stored);
    for (std::size_t i = 0; i < cut.width_groups(); ++i)
      widths_of_widths_[i] = static_cast<std::uint32_t>(stored[i]);
    check_widths(widths_of_widths_, kMostBitsOfWidths);
    stored = stored.subspan(cut.width_groups());
    expect_at_least(Sizes(*this, cut).widths, stored);
    unpack_groups(stored.data(), stored.size(), widths_of_widths_.data(), cut.width_groups(),
                  std::as_writable_bytes(std::span(widths_)).data());
    check_widths(widths_, kMostBits);

    const Sizes sizes(*this, cut);
    if (sizes.all() != found)
      throw Error(ErrorCode::kCorruption,
                  fmt::format("decode bitpack: expected {} bytes, found {}", sizes.all(), found));
    stored = stored.subspan(sizes.widths);
    unpack_groups(stored.data(), sizes.whole, widths_.data(), cut.whole, raw.data());
    if (cut.last_words > 0) {
      GroupBytes packed{}, last;
      std::ranges::copy(stored.subspan(sizes.whole, sizes.last), packed.begin());
      unpack_groups(packed.data(), packed.size(), &widths_[cut.whole], 1, last.data());
      std::copy_n(last.begin(), cut.last_words * kWordBytes,
                  raw.subspan(cut.whole * kGroupBytes).begin());
    }
    std::ranges::copy(stored.last(cut.bytes), raw.last(cut.bytes).begin());
  }

 private:
  /// The bytes of the parts of a block, by the widths that the codec has at the moment.
  struct Sizes {
    std::size_t widths_of_widths, widths, whole, last, bytes;

    Sizes(const BitpackCodec& codec, const Cut& cut)
        : widths_of_widths(cut.width_groups()),
          widths(packed_bytes(kGroupWords * sum(codec.widths_of_widths_), 1)),
          whole(packed_bytes(kGroupWords * sum(std::span(codec.widths_).first(cut.whole)), 1)),
          last(cut.last_words > 0 ? packed_bytes(cut.last_words, codec.widths_[cut.whole]) : 0),
          bytes(cut.bytes) {}
    std::size_t all() const { return widths_of_widths + widths + whole + last + bytes; }
  };

  void make_room(const Cut& cut) {
    fill_with_zeros(widths_of_widths_, cut.width_groups());
    fill_with_zeros(widths_, cut.width_groups() * kGroupWords);
  }
  /// The former memory goes before the new one comes, so that memory_bytes() is the peak.
  static void fill_with_zeros(std::vector<std::uint32_t>& widths, std::size_t count) {
    if (widths.capacity() < count) widths = {};
    widths.assign(count, 0);
  }
  static void expect_at_least(std::size_t bytes, std::span<const std::byte> stored) {
    if (stored.size() < bytes)
      throw Error(ErrorCode::kCorruption,
                  fmt::format("decode bitpack: expected widths of {} bytes, found {}", bytes,
                              stored.size()));
  }
  static void check_widths(std::span<const std::uint32_t> widths, std::uint32_t most) {
    const auto largest = std::ranges::max_element(widths);
    if (largest != widths.end() && *largest > most)
      throw Error(ErrorCode::kCorruption,
                  fmt::format("decode bitpack: expected widths of at most {} bits, found {}", most,
                              *largest));
  }

  std::vector<std::uint32_t> widths_, widths_of_widths_;
};

}  // namespace

std::unique_ptr<Codec> make_bitpack_codec(std::string_view options) {
  refuse_options("bitpack", options);
  return std::make_unique<BitpackCodec>();
}

PLAIT_END_NAMESPACE
