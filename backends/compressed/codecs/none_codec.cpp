#include <fmt/format.h>

#include <algorithm>

#include "base/text.h"
#include "compressed/codecs/built_in_codecs.h"
#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

class NoneCodec final : public Codec {
 public:
  std::size_t bound(std::size_t raw_bytes) const override { return raw_bytes; }
  std::size_t memory_bytes(std::size_t) const override { return 0; }

  std::optional<std::size_t> compress(std::span<const std::byte> raw,
                                      std::span<std::byte> into) override {
    if (raw.size() > into.size()) return std::nullopt;
    std::copy(raw.begin(), raw.end(), into.begin());
    return raw.size();
  }

  void decompress(std::span<const std::byte> stored, std::span<std::byte> raw) override {
    if (stored.size() != raw.size())
      throw Error(ErrorCode::kCorruption, fmt::format("decode none: expected {} bytes, found {}",
                                                      raw.size(), stored.size()));
    std::copy(stored.begin(), stored.end(), raw.begin());
  }
};

}  // namespace

std::unique_ptr<Codec> make_none_codec(std::string_view options) {
  refuse_options("none", options);
  return std::make_unique<NoneCodec>();
}

void refuse_options(std::string_view name, std::string_view options) {
  if (options.empty()) return;
  throw Error(ErrorCode::kInvalidArgument,
              fmt::format("choose \"{}:{}\": expected no options after the name", name,
                          text_for_message(options)));
}

PLAIT_END_NAMESPACE
