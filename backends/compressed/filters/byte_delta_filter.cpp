#include "compressed/filters/byte_delta_filter.h"

#include <algorithm>

#include "compressed/codecs/built_in_codecs.h"
#include "compressed/filters/byte_planes.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

class ByteDeltaFilter final : public Filter {
 public:
  ByteDeltaFilter(std::size_t width, std::size_t components)
      : width_(width), components_(components) {}

  void encode(const FilterBlock&, std::span<const std::byte> raw,
              std::span<std::byte> filtered) const override {
    in_each_plane(raw, filtered, byte_differences);
  }
  void decode(const FilterBlock&, std::span<const std::byte> filtered,
              std::span<std::byte> raw) const override {
    in_each_plane(filtered, raw, byte_sums);
  }

 private:
  template <class Function>
  void in_each_plane(std::span<const std::byte> from, std::span<std::byte> to,
                     Function function) const {
    const std::size_t count = from.size() / width_;
    for (std::size_t plane = 0; plane < width_; ++plane)
      function(from.data() + plane * count, count, components_, to.data() + plane * count);
    std::ranges::copy(from.subspan(width_ * count), to.subspan(width_ * count).begin());
  }

  std::size_t width_, components_;
};

}  // namespace

std::unique_ptr<Filter> make_byte_delta_filter(std::string_view options, const FilterLevel& level) {
  refuse_options("bytedelta", options);
  return std::make_unique<ByteDeltaFilter>(component_bytes(level.schema.type),
                                           level.schema.components);
}

PLAIT_END_NAMESPACE
