#include "peers/compression_peers.h"

#include <algorithm>
#include <cstring>

#if defined(PLAIT_BENCH_BLOSC)
#include <blosc.h>
#endif
#if defined(PLAIT_BENCH_FPZIP)
#include <fpzip.h>
#endif
#if defined(PLAIT_BENCH_MESHOPTIMIZER)
#include <meshoptimizer.h>
#include <zstd.h>
#endif
#if defined(PLAIT_BENCH_ZFP)
#include <zfp.h>
#endif

namespace plait::bench {
namespace {

using Bytes = std::vector<std::byte>;
[[maybe_unused]] constexpr std::size_t kRecord = 12;

/// x of all records, then y, then z.
[[maybe_unused]] std::vector<float> by_component(std::span<const std::byte> raw) {
  std::vector<float> numbers(raw.size() / 4);
  const std::size_t records = numbers.size() / 3;
  for (std::size_t i = 0; i < numbers.size(); ++i)
    std::memcpy(&numbers[i % 3 * records + i / 3], raw.data() + 4 * i, 4);
  return numbers;
}
[[maybe_unused]] void by_record(const std::vector<float>& numbers, std::span<std::byte> raw) {
  const std::size_t records = numbers.size() / 3;
  for (std::size_t i = 0; i < numbers.size(); ++i)
    std::memcpy(raw.data() + 4 * i, &numbers[i % 3 * records + i / 3], 4);
}

#if defined(PLAIT_BENCH_BLOSC)
CompressionPeer blosc(const char* codec, int level, int shuffle, const char* name) {
  return {name,
          [=](const PeerBlock& block) {
            Bytes to(block.raw.size() + BLOSC_MAX_OVERHEAD);
            const int size =
                blosc_compress_ctx(level, shuffle, 4, block.raw.size(), block.raw.data(), to.data(),
                                   to.size(), codec, 0, 1);
            to.resize(size > 0 ? static_cast<std::size_t>(size) : 0);
            return to;
          },
          [](std::span<const std::byte> encoded, const PeerBlock&, std::span<std::byte> raw) {
            return blosc_decompress_ctx(encoded.data(), raw.data(), raw.size(), 1) ==
                   static_cast<int>(raw.size());
          }};
}
#endif

#if defined(PLAIT_BENCH_FPZIP)
CompressionPeer fpzip() {
  const auto describe = [](FPZ* stream, const PeerBlock& block) {
    stream->type = FPZIP_TYPE_FLOAT;
    stream->prec = 0;
    stream->nx = static_cast<int>(block.columns);
    stream->ny = static_cast<int>(block.rows);
    stream->nz = 1;
    stream->nf = 3;
  };
  return {
      "fpzip",
      [=](const PeerBlock& block) {
        const std::vector<float> numbers = by_component(block.raw);
        Bytes to(2 * block.raw.size() + 1024);
        FPZ* const stream = fpzip_write_to_buffer(to.data(), to.size());
        describe(stream, block);
        to.resize(fpzip_write(stream, numbers.data()));
        fpzip_write_close(stream);
        return to;
      },
      [=](std::span<const std::byte> encoded, const PeerBlock& block, std::span<std::byte> raw) {
        std::vector<float> numbers(raw.size() / 4);
        FPZ* const stream = fpzip_read_from_buffer(encoded.data());
        describe(stream, block);
        const bool done = fpzip_read(stream, numbers.data()) != 0;
        fpzip_read_close(stream);
        by_record(numbers, raw);
        return done;
      }};
}
#endif

#if defined(PLAIT_BENCH_MESHOPTIMIZER)
CompressionPeer meshoptimizer() {
  return {"meshoptimizer, zstd 1",
          [](const PeerBlock& block) {
            const std::size_t count = block.raw.size() / kRecord;
            std::vector<unsigned char> vertices(meshopt_encodeVertexBufferBound(count, kRecord));
            vertices.resize(meshopt_encodeVertexBuffer(vertices.data(), vertices.size(),
                                                       block.raw.data(), count, kRecord));
            Bytes to(ZSTD_compressBound(vertices.size()));
            to.resize(ZSTD_compress(to.data(), to.size(), vertices.data(), vertices.size(), 1));
            return to;
          },
          [](std::span<const std::byte> encoded, const PeerBlock&, std::span<std::byte> raw) {
            std::vector<unsigned char> vertices(
                ZSTD_getFrameContentSize(encoded.data(), encoded.size()));
            ZSTD_decompress(vertices.data(), vertices.size(), encoded.data(), encoded.size());
            return meshopt_decodeVertexBuffer(raw.data(), raw.size() / kRecord, kRecord,
                                              vertices.data(), vertices.size()) == 0;
          }};
}
#endif

#if defined(PLAIT_BENCH_ZFP)
CompressionPeer zfp() {
  // One stream for each component, one after another.
  const auto each = [](float* numbers, const PeerBlock& block, bitstream* bits, auto code) {
    zfp_stream* const stream = zfp_stream_open(bits);
    zfp_stream_set_reversible(stream);
    bool done = true;
    for (std::size_t component = 0; component < 3; ++component) {
      zfp_field* const field = zfp_field_2d(numbers + component * block.columns * block.rows,
                                            zfp_type_float, block.columns, block.rows);
      done = code(stream, field) != 0 && done;
      zfp_field_free(field);
    }
    const std::size_t size = zfp_stream_compressed_size(stream);
    zfp_stream_close(stream);
    return done ? size : 0;
  };
  return {
      "zfp, reversible, 2-D",
      [=](const PeerBlock& block) {
        std::vector<float> numbers = by_component(block.raw);
        Bytes to(2 * block.raw.size() + 4096);
        bitstream* const bits = stream_open(to.data(), to.size());
        to.resize(each(numbers.data(), block, bits, zfp_compress));
        stream_close(bits);
        return to;
      },
      [=](std::span<const std::byte> encoded, const PeerBlock& block, std::span<std::byte> raw) {
        std::vector<float> numbers(raw.size() / 4);
        Bytes copy(encoded.begin(), encoded.end());
        copy.resize(copy.size() + 64);  // it reads whole words
        bitstream* const bits = stream_open(copy.data(), copy.size());
        const bool done = each(numbers.data(), block, bits, zfp_decompress) != 0;
        stream_close(bits);
        by_record(numbers, raw);
        return done;
      }};
}
#endif

}  // namespace

std::vector<CompressionPeer> compression_peers() {
  std::vector<CompressionPeer> peers;
#if defined(PLAIT_BENCH_BLOSC)
  peers.push_back(blosc("lz4", 5, BLOSC_SHUFFLE, "Blosc 1, shuffle, LZ4 5"));
  peers.push_back(blosc("zstd", 3, BLOSC_SHUFFLE, "Blosc 1, shuffle, zstd 3"));
  peers.push_back(blosc("zstd", 3, BLOSC_BITSHUFFLE, "Blosc 1, bitshuffle, zstd 3"));
#endif
#if defined(PLAIT_BENCH_FPZIP)
  peers.push_back(fpzip());
#endif
#if defined(PLAIT_BENCH_MESHOPTIMIZER)
  peers.push_back(meshoptimizer());
#endif
#if defined(PLAIT_BENCH_ZFP)
  peers.push_back(zfp());
#endif
  return peers;
}

}  // namespace plait::bench
