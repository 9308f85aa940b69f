#include <fmt/format.h>
#define ZSTD_STATIC_LINKING_ONLY  // declares the estimates of memory
#include <zstd.h>
#include <zstd_errors.h>

#include <algorithm>
#include <charconv>

#include "compressed/codecs/built_in_codecs.h"
#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr std::size_t kKibi = 1024;

struct FreeContext {
  void operator()(ZSTD_CCtx* context) const { ZSTD_freeCCtx(context); }
  void operator()(ZSTD_DCtx* context) const { ZSTD_freeDCtx(context); }
};

/// One zstd frame with its content size. The frame has no checksum, because plait stores one for
/// each block.
class ZstdCodec final : public Codec {
 public:
  explicit ZstdCodec(int level) : level_(level) {}

  std::size_t bound(std::size_t raw_bytes) const override { return ZSTD_compressBound(raw_bytes); }

  std::size_t memory_bytes(std::size_t raw_bytes) const override {
    // zstd chooses the size of its tables by one of four classes of input size, and the tables of a
    // smaller class may be larger. So the maximum over the classes counts.
    std::size_t most = 0;
    for (const std::size_t class_bytes : {raw_bytes, 256 * kKibi, 128 * kKibi, 16 * kKibi})
      most = std::max(most, ZSTD_estimateCCtxSize_usingCParams(
                                ZSTD_getCParams(level_, std::min(raw_bytes, class_bytes), 0)));
    return most + ZSTD_estimateDCtxSize();
  }

  std::optional<std::size_t> compress(std::span<const std::byte> raw,
                                      std::span<std::byte> into) override {
    if (!compressor_) {
      compressor_.reset(ZSTD_createCCtx());
      if (!compressor_)
        throw Error(ErrorCode::kOutOfMemory, "encode zstd: no memory for a context");
      ZSTD_CCtx_setParameter(compressor_.get(), ZSTD_c_compressionLevel, level_);
    }
    const std::size_t stored =
        ZSTD_compress2(compressor_.get(), into.data(), into.size(), raw.data(), raw.size());
    if (!ZSTD_isError(stored)) return stored;
    if (ZSTD_getErrorCode(stored) == ZSTD_error_dstSize_tooSmall) return std::nullopt;
    throw Error(ErrorCode::kOutOfMemory, fmt::format("encode zstd: {}", ZSTD_getErrorName(stored)));
  }

  void decompress(std::span<const std::byte> stored, std::span<std::byte> raw) override {
    if (!decompressor_) {
      decompressor_.reset(ZSTD_createDCtx());
      if (!decompressor_)
        throw Error(ErrorCode::kOutOfMemory, "decode zstd: no memory for a context");
    }
    const unsigned long long declared = ZSTD_getFrameContentSize(stored.data(), stored.size());
    if (declared != raw.size())
      throw Error(
          ErrorCode::kCorruption,
          fmt::format("decode zstd: expected a frame of {} bytes, found {}", raw.size(),
                      declared >= ZSTD_CONTENTSIZE_ERROR ? "none" : std::to_string(declared)));
    const std::size_t decoded = ZSTD_decompressDCtx(decompressor_.get(), raw.data(), raw.size(),
                                                    stored.data(), stored.size());
    if (ZSTD_isError(decoded))
      throw Error(ErrorCode::kCorruption, fmt::format("decode zstd: expected {} bytes, found: {}",
                                                      raw.size(), ZSTD_getErrorName(decoded)));
    if (decoded != raw.size())
      throw Error(ErrorCode::kCorruption,
                  fmt::format("decode zstd: expected {} bytes, found {}", raw.size(), decoded));
  }

 private:
  int level_;
  std::unique_ptr<ZSTD_CCtx, FreeContext> compressor_;
  std::unique_ptr<ZSTD_DCtx, FreeContext> decompressor_;
};

}  // namespace

std::unique_ptr<Codec> make_zstd_codec(std::string_view options) {
  int level = ZSTD_defaultCLevel();
  if (!options.empty()) {
    const char* const end = options.data() + options.size();
    const auto [stop, failure] = std::from_chars(options.data(), end, level);
    if (failure != std::errc() || stop != end || level < ZSTD_minCLevel() ||
        level > ZSTD_maxCLevel())
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("choose codec \"zstd:{}\": expected a level from {} to {}", options,
                              ZSTD_minCLevel(), ZSTD_maxCLevel()));
  }
  return std::make_unique<ZstdCodec>(level);
}

PLAIT_END_NAMESPACE
