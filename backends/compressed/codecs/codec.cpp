#include "compressed/codecs/codec.h"

#include <fmt/format.h>

#include <algorithm>

#include "plait/error.h"

namespace plait {
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

bool is_codec(std::string_view stage) {
  const std::string_view name = stage.substr(0, stage.find(':'));
  return name == "lz4" || name == "zstd";
}

std::unique_ptr<Codec> make_codec(std::string_view specification) {
  constexpr std::string_view kZstdLevel = "zstd:";
  if (specification == "none") return std::make_unique<NoneCodec>();
  if (specification == "lz4") return make_lz4_codec();
  if (specification == "zstd") return make_zstd_codec(std::nullopt);
  if (specification.starts_with(kZstdLevel))
    return make_zstd_codec(specification.substr(kZstdLevel.size()));
  throw Error(ErrorCode::kNotSupported,
              fmt::format("choose codec \"{}\": expected one of none, lz4, zstd, zstd:LEVEL",
                          specification));
}

}  // namespace plait
