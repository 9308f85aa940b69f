#include <fmt/format.h>
#include <lz4.h>

#include "compressed/codecs/built_in_codecs.h"
#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// The LZ4 block format. Callers pass blocks of at most LZ4_MAX_INPUT_SIZE bytes, so sizes fit an
/// int.
class Lz4Codec final : public Codec {
 public:
  std::size_t bound(std::size_t raw_bytes) const override {
    return static_cast<std::size_t>(LZ4_compressBound(static_cast<int>(raw_bytes)));
  }

  std::size_t memory_bytes(std::size_t) const override { return 0; }  // LZ4 uses the stack

  std::optional<std::size_t> compress(std::span<const std::byte> raw,
                                      std::span<std::byte> into) override {
    const int stored = LZ4_compress_default(
        reinterpret_cast<const char*>(raw.data()), reinterpret_cast<char*>(into.data()),
        static_cast<int>(raw.size()), static_cast<int>(into.size()));
    if (stored <= 0) return std::nullopt;
    return static_cast<std::size_t>(stored);
  }

  void decompress(std::span<const std::byte> stored, std::span<std::byte> raw) override {
    const int decoded = LZ4_decompress_safe(
        reinterpret_cast<const char*>(stored.data()), reinterpret_cast<char*>(raw.data()),
        static_cast<int>(stored.size()), static_cast<int>(raw.size()));
    if (decoded < 0)
      throw Error(ErrorCode::kCorruption,
                  fmt::format("decode lz4: expected {} bytes, found a damaged stream", raw.size()));
    if (static_cast<std::size_t>(decoded) != raw.size())
      throw Error(ErrorCode::kCorruption,
                  fmt::format("decode lz4: expected {} bytes, found {}", raw.size(), decoded));
  }
};

}  // namespace

std::unique_ptr<Codec> make_lz4_codec(std::string_view options) {
  refuse_options("lz4", options);
  return std::make_unique<Lz4Codec>();
}

PLAIT_END_NAMESPACE
