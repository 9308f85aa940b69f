#include <algorithm>

#include "compressed/filters/built_in_filters.h"
#include "compressed/filters/byte_planes.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

class ShuffleFilter final : public Filter {
 public:
  explicit ShuffleFilter(std::size_t width) : width_(width) {}

  void encode(const FilterBlock&, std::span<const std::byte> raw,
              std::span<std::byte> filtered) const override {
    split_planes(raw.data(), raw.size() / width_, width_, filtered.data());
    copy_rest(raw, filtered);
  }

  void decode(const FilterBlock&, std::span<const std::byte> filtered,
              std::span<std::byte> raw) const override {
    join_planes(filtered.data(), raw.size() / width_, width_, raw.data());
    copy_rest(filtered, raw);
  }

 private:
  void copy_rest(std::span<const std::byte> from, std::span<std::byte> to) const {
    const std::size_t whole = from.size() / width_ * width_;
    std::ranges::copy(from.subspan(whole), to.subspan(whole).begin());
  }

  std::size_t width_;
};

}  // namespace

std::unique_ptr<Filter> make_shuffle_filter(std::size_t component_bytes) {
  return std::make_unique<ShuffleFilter>(component_bytes);
}

PLAIT_END_NAMESPACE
