// Compares Input's decompression with the libraries' own decoders. Whole gzip and zstd files give
// the same bytes, and files that are damaged or cut short are refused.
#include <zlib.h>
#include <zstd.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "memory_file.h"
#include "mesh/files/input.h"
#include "mesh/files/zstd_frames.h"
#include "oracle.h"

using namespace plait;
using namespace plait::fuzz;

namespace {

/// Compares at most so many bytes, because a small file may decompress to gigabytes of zeros.
constexpr std::size_t kMaxBytes = std::size_t{1} << 20;

/// The decompressed bytes: at most kMaxBytes and one buffer more. Nothing if Input refuses the
/// file.
std::optional<std::string> read_input(const std::filesystem::path& path) {
  std::string bytes;
  const bool whole = accepts({ErrorCode::kInvalidArgument}, [&] {
    Input input(path);
    do {
      bytes += input.unread();
      require(input.offset() + input.unread().size() == bytes.size());
      input.consume(input.unread().size());
    } while (bytes.size() <= kMaxBytes && input.fill());
  });
  return whole ? std::optional(bytes) : std::nullopt;
}

/// The result of zlib. `unsettled`: zlib refuses the file for reserved flags or for the checksum of
/// a header. Boost's decoder does not check these, so the two results are not compared.
struct Gzip {
  std::optional<std::string> bytes;
  bool unsettled = false;
};
Gzip decode_gzip(std::string_view file) {
  std::string bytes(kMaxBytes + 1, '\0');
  z_stream stream{};
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(file.data()));
  stream.avail_in = static_cast<uInt>(file.size());
  stream.next_out = reinterpret_cast<Bytef*>(bytes.data());
  stream.avail_out = static_cast<uInt>(bytes.size());
  constexpr int kGzipOnly = 16;
  require(inflateInit2(&stream, MAX_WBITS + kGzipOnly) == Z_OK);
  const auto stopped_by = [&](std::string_view reason) { return stream.msg == reason; };
  int result = Z_OK;
  while (stream.avail_out > 0 &&
         (result == Z_OK || (result == Z_STREAM_END && stream.avail_in > 0))) {
    if (result == Z_STREAM_END) inflateReset(&stream);  // another member follows
    result = inflate(&stream, Z_NO_FLUSH);
    // Boost does not check the length after the checksum either. zlib can continue after that
    // error.
    if (result == Z_DATA_ERROR && stopped_by("incorrect length check")) result = Z_STREAM_END;
  }
  const bool unsettled = result == Z_DATA_ERROR && (stopped_by("unknown header flags set") ||
                                                    stopped_by("header crc mismatch"));
  bytes.erase(bytes.size() - stream.avail_out);
  inflateEnd(&stream);
  const bool whole = result == Z_STREAM_END || bytes.size() > kMaxBytes;
  return {whole ? std::optional(bytes) : std::nullopt, unsettled};
}

std::optional<std::string> decode_zstd(std::string_view file) {
  const std::unique_ptr<ZSTD_DCtx, std::size_t (*)(ZSTD_DCtx*)> context(ZSTD_createDCtx(),
                                                                        ZSTD_freeDCtx);
  std::string bytes(kMaxBytes + 1, '\0');
  ZSTD_outBuffer out = {bytes.data(), bytes.size(), 0};
  ZSTD_inBuffer in = {file.data(), file.size(), 0};
  std::size_t wanted = 0;  // bytes until the end of the frame; 0 at its end
  while (in.pos < in.size || wanted != 0) {
    const std::size_t in_before = in.pos, out_before = out.pos;
    wanted = ZSTD_decompressStream(context.get(), &out, &in);
    if (ZSTD_isError(wanted)) return std::nullopt;
    if (out.pos == out.size) break;
    if (in.pos == in_before && out.pos == out_before) break;
  }
  if (wanted != 0 && out.pos < out.size) return std::nullopt;
  bytes.erase(out.pos);
  return bytes;
}

bool ends_with_frame(std::string_view file, std::size_t step) {
  ZstdFrames frames;
  for (std::size_t at = 0; at < file.size(); at += step) frames.follow(file.substr(at, step));
  return frames.at_end();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view file(reinterpret_cast<const char*>(data), size);
  const std::optional<std::string> bytes = read_input(path_of(data, size));
  const bool is_zstd = ZstdFrames::starts_with_frame(file);
  std::optional<std::string> expected(file);
  if (is_zstd) {
    expected = decode_zstd(file);
  } else if (file.starts_with("\x1f\x8b")) {
    Gzip gzip = decode_gzip(file);
    if (gzip.unsettled) return 0;
    expected = std::move(gzip.bytes);
  }
  if ((bytes && bytes->size() > kMaxBytes) || (expected && expected->size() > kMaxBytes)) return 0;
  require(bytes == expected);
  if (!is_zstd) return 0;
  require(ends_with_frame(file, 1) == ends_with_frame(file, 7));
  require(!expected || ends_with_frame(file, file.size()));
  return 0;
}
