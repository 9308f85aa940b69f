// The codec `zstd`. A block is cut into parts, and each part is a zstd frame by itself. After
// `shuffle`, a part holds bytes of one significance. Where the lower bytes of residuals are noise,
// zstd finds many short matches, which save nothing and make decoding three times as slow. So each
// part is encoded twice, with matches and with Huffman codes alone, and the second is taken unless
// the first is clearly smaller.
#include <fmt/format.h>
#define ZSTD_STATIC_LINKING_ONLY  // declares the estimates of memory, and the mode of literals
#include <zstd.h>
#include <zstd_errors.h>

#include <algorithm>
#include <charconv>
#include <cstring>
#include <vector>

#include "base/text.h"
#include "compressed/codecs/built_in_codecs.h"
#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr std::size_t kKibi = 1024;

/// Numbers of 4 bytes have four planes of bytes, numbers of 8 bytes eight. So that parts are whole
/// planes or halves of them, there are eight; smaller blocks would pay too much for the headers.
constexpr std::size_t kParts = 8, kLeastBytesInParts = 32 * kKibi;
constexpr std::size_t count_parts(std::size_t raw_bytes) {
  return raw_bytes < kLeastBytesInParts ? 1 : kParts;
}
/// Where part `part` begins; where the block ends for the number of parts.
constexpr std::size_t part_begin(std::size_t raw_bytes, std::size_t part) {
  return raw_bytes * part / count_parts(raw_bytes);
}

/// Huffman codes decode faster than matches, so matches must save at least this share.
constexpr std::size_t kLeastGain = 32;
/// A part of one value, or nearly so: there is nothing to gain.
constexpr std::size_t kSmallPart = 64;

struct FreeContext {
  void operator()(ZSTD_CCtx* context) const { ZSTD_freeCCtx(context); }
  void operator()(ZSTD_DCtx* context) const { ZSTD_freeDCtx(context); }
};
using Compressor = std::unique_ptr<ZSTD_CCtx, FreeContext>;

/// The parameters with which zstd searches as good as nothing, and so encodes literals alone.
ZSTD_compressionParameters literal_parameters(std::size_t raw_bytes) {
  ZSTD_compressionParameters parameters = ZSTD_getCParams(1, raw_bytes, 0);
  parameters.strategy = ZSTD_fast;
  parameters.hashLog = 6;
  parameters.chainLog = 6;
  parameters.minMatch = 7;
  parameters.targetLength = ZSTD_TARGETLENGTH_MAX;  // the step from one search to the next
  return parameters;
}

/// Frames with their content sizes. They have no checksums, because plait stores one for each
/// block.
class ZstdCodec final : public Codec {
 public:
  explicit ZstdCodec(int level) : level_(level) {}

  std::size_t bound(std::size_t raw_bytes) const override {
    std::size_t all = 0;
    for (std::size_t part = 0; part < count_parts(raw_bytes); ++part)
      all += ZSTD_compressBound(part_begin(raw_bytes, part + 1) - part_begin(raw_bytes, part));
    return all;
  }

  std::size_t memory_bytes(std::size_t raw_bytes) const override {
    // zstd chooses the size of its tables by one of four classes of input size, and the tables of a
    // smaller class may be larger. So the maximum over the classes counts.
    std::size_t most = 0, most_literal = 0;
    for (const std::size_t class_bytes : {raw_bytes, 256 * kKibi, 128 * kKibi, 16 * kKibi}) {
      const std::size_t bytes = std::min(raw_bytes, class_bytes);
      most = std::max(most, ZSTD_estimateCCtxSize_usingCParams(ZSTD_getCParams(level_, bytes, 0)));
      most_literal =
          std::max(most_literal, ZSTD_estimateCCtxSize_usingCParams(literal_parameters(bytes)));
    }
    return most + ZSTD_compressBound(raw_bytes / count_parts(raw_bytes) + 1) + most_literal +
           ZSTD_estimateDCtxSize();
  }

  std::optional<std::size_t> compress(std::span<const std::byte> raw,
                                      std::span<std::byte> into) override {
    make_compressors();
    std::size_t stored = 0;
    for (std::size_t part = 0; part < count_parts(raw.size()); ++part) {
      const std::size_t begin = part_begin(raw.size(), part);
      const auto added = compress_part(raw.subspan(begin, part_begin(raw.size(), part + 1) - begin),
                                       into.subspan(stored));
      if (!added) return std::nullopt;
      stored += *added;
    }
    return stored;
  }

  void decompress(std::span<const std::byte> stored, std::span<std::byte> raw) override {
    if (!decompressor_) {
      decompressor_.reset(ZSTD_createDCtx());
      if (!decompressor_)
        throw Error(ErrorCode::kOutOfMemory, "decode zstd: no memory for a context");
    }
    const std::size_t parts = count_parts(raw.size());
    for (std::size_t part = 0; part < parts; ++part) {
      const std::size_t begin = part_begin(raw.size(), part);
      stored =
          decompress_part(stored, raw.subspan(begin, part_begin(raw.size(), part + 1) - begin));
    }
    if (!stored.empty())
      throw Error(ErrorCode::kCorruption,
                  fmt::format("decode zstd: expected the end of {} frames, found {} bytes more",
                              parts, stored.size()));
  }

 private:
  static Compressor make_compressor() {
    Compressor made(ZSTD_createCCtx());
    if (!made) throw Error(ErrorCode::kOutOfMemory, "encode zstd: no memory for a context");
    return made;
  }

  void make_compressors() {
    if (searching_) return;
    literal_ = make_compressor();
    // A long step turns literal compression off, unless it is asked for.
    set(literal_, ZSTD_c_literalCompressionMode, ZSTD_ps_enable);
    searching_ = make_compressor();
    set(searching_, ZSTD_c_compressionLevel, level_);
  }

  static void set(Compressor& compressor, ZSTD_cParameter parameter, long long value) {
    const std::size_t found =
        ZSTD_CCtx_setParameter(compressor.get(), parameter, static_cast<int>(value));
    if (ZSTD_isError(found))
      throw Error(ErrorCode::kNotSupported,
                  fmt::format("encode zstd: {}", ZSTD_getErrorName(found)));
  }

  void set_literal_parameters(std::size_t raw_bytes) {
    const ZSTD_compressionParameters parameters = literal_parameters(raw_bytes);
    // After a part that did not fit, a compressor keeps its window unless it is reset.
    ZSTD_CCtx_reset(literal_.get(), ZSTD_reset_session_only);
    set(literal_, ZSTD_c_windowLog, parameters.windowLog);
    set(literal_, ZSTD_c_hashLog, parameters.hashLog);
    set(literal_, ZSTD_c_chainLog, parameters.chainLog);
    set(literal_, ZSTD_c_minMatch, parameters.minMatch);
    set(literal_, ZSTD_c_strategy, parameters.strategy);
    set(literal_, ZSTD_c_targetLength, parameters.targetLength);
  }

  /// The size of the frame; nothing if it does not fit.
  static std::optional<std::size_t> frame(ZSTD_CCtx* compressor, std::span<const std::byte> raw,
                                          std::span<std::byte> into) {
    const std::size_t stored =
        ZSTD_compress2(compressor, into.data(), into.size(), raw.data(), raw.size());
    if (!ZSTD_isError(stored)) return stored;
    if (ZSTD_getErrorCode(stored) == ZSTD_error_dstSize_tooSmall) return std::nullopt;
    throw Error(ErrorCode::kOutOfMemory, fmt::format("encode zstd: {}", ZSTD_getErrorName(stored)));
  }

  std::optional<std::size_t> compress_part(std::span<const std::byte> raw,
                                           std::span<std::byte> into) {
    set_literal_parameters(raw.size());
    const auto literal = frame(literal_.get(), raw, into);
    if (literal && *literal <= kSmallPart) return literal;
    searched_.resize(std::max(searched_.size(), ZSTD_compressBound(raw.size())));
    const std::size_t searched = *frame(searching_.get(), raw, searched_);
    if (literal && *literal <= searched + searched / kLeastGain) return literal;
    if (searched > into.size()) return std::nullopt;
    std::memcpy(into.data(), searched_.data(), searched);
    return searched;
  }

  /// Returns the bytes after the part's frame.
  std::span<const std::byte> decompress_part(std::span<const std::byte> stored,
                                             std::span<std::byte> raw) {
    const unsigned long long declared = ZSTD_getFrameContentSize(stored.data(), stored.size());
    if (declared != raw.size())
      throw Error(
          ErrorCode::kCorruption,
          fmt::format("decode zstd: expected a frame of {} bytes, found {}", raw.size(),
                      declared >= ZSTD_CONTENTSIZE_ERROR ? "none" : std::to_string(declared)));
    const std::size_t frame_bytes = ZSTD_findFrameCompressedSize(stored.data(), stored.size());
    if (ZSTD_isError(frame_bytes))
      throw Error(ErrorCode::kCorruption, fmt::format("decode zstd: expected {} bytes, found: {}",
                                                      raw.size(), ZSTD_getErrorName(frame_bytes)));
    const std::size_t decoded = ZSTD_decompressDCtx(decompressor_.get(), raw.data(), raw.size(),
                                                    stored.data(), frame_bytes);
    if (ZSTD_isError(decoded))
      throw Error(ErrorCode::kCorruption, fmt::format("decode zstd: expected {} bytes, found: {}",
                                                      raw.size(), ZSTD_getErrorName(decoded)));
    if (decoded != raw.size())
      throw Error(ErrorCode::kCorruption,
                  fmt::format("decode zstd: expected {} bytes, found {}", raw.size(), decoded));
    return stored.subspan(frame_bytes);
  }

  int level_;
  Compressor searching_, literal_;  ///< with matches, and with Huffman codes alone
  std::vector<std::byte> searched_;
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
                  fmt::format("choose codec \"zstd:{}\": expected a level from {} to {}",
                              text_for_message(options), ZSTD_minCLevel(), ZSTD_maxCLevel()));
  }
  return std::make_unique<ZstdCodec>(level);
}

PLAIT_END_NAMESPACE
