#include "compressed/filters/shuffle_filter.h"

#include <algorithm>

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

template <std::size_t kWidth>
class ShuffleFilter final : public Filter {
 public:
  void encode(const FilterBlock&, std::span<const std::byte> raw,
              std::span<std::byte> filtered) const override {
    const std::size_t count = raw.size() / kWidth;
    const std::byte* const from = raw.data();
    for (std::size_t plane = 0; plane < kWidth; ++plane) {
      std::byte* const into = filtered.data() + plane * count;
      for (std::size_t i = 0; i < count; ++i) into[i] = from[i * kWidth + plane];
    }
    copy_rest(raw, filtered);
  }

  void decode(const FilterBlock&, std::span<const std::byte> filtered,
              std::span<std::byte> raw) const override {
    const std::size_t count = raw.size() / kWidth;
    const std::byte* const from = filtered.data();
    std::byte* const into = raw.data();
    for (std::size_t i = 0; i < count; ++i)
      for (std::size_t plane = 0; plane < kWidth; ++plane)
        into[i * kWidth + plane] = from[plane * count + i];
    copy_rest(filtered, raw);
  }

 private:
  static void copy_rest(std::span<const std::byte> from, std::span<std::byte> into) {
    const std::size_t whole = from.size() / kWidth * kWidth;
    std::copy(from.begin() + static_cast<std::ptrdiff_t>(whole), from.end(),
              into.begin() + static_cast<std::ptrdiff_t>(whole));
  }
};

}  // namespace

std::unique_ptr<Filter> make_shuffle_filter(std::size_t component_bytes) {
  if (component_bytes == 2) return std::make_unique<ShuffleFilter<2>>();
  if (component_bytes == 4) return std::make_unique<ShuffleFilter<4>>();
  return std::make_unique<ShuffleFilter<8>>();
}

PLAIT_END_NAMESPACE
