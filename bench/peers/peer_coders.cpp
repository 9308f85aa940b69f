#include <cstring>

#include "peers/coders.h"

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

using Encoded = std::span<const std::byte>;
using Bytes = std::span<std::byte>;

/// x of all records, then y, then z.
[[maybe_unused]] std::vector<float> by_component(Encoded raw) {
  std::vector<float> numbers(raw.size() / 4);
  const std::size_t records = numbers.size() / 3;
  for (std::size_t i = 0; i < numbers.size(); ++i)
    std::memcpy(&numbers[i % 3 * records + i / 3], raw.data() + 4 * i, 4);
  return numbers;
}
[[maybe_unused]] void by_record(const std::vector<float>& numbers, Bytes raw) {
  const std::size_t records = numbers.size() / 3;
  for (std::size_t i = 0; i < numbers.size(); ++i)
    std::memcpy(raw.data() + 4 * i, &numbers[i % 3 * records + i / 3], 4);
}

#if defined(PLAIT_BENCH_BLOSC)
Coder blosc() {
  return {"Blosc 1, bitshuffle, zstd 3",
          [](const RawBlock& block, Bytes to) {
            const int size =
                blosc_compress_ctx(3, BLOSC_BITSHUFFLE, 4, block.raw.size(), block.raw.data(),
                                   to.data(), to.size(), "zstd", 0, 1);
            return size > 0 ? static_cast<std::size_t>(size) : 0;
          },
          [](Encoded encoded, const RawBlock&, Bytes raw) {
            return blosc_decompress_ctx(encoded.data(), raw.data(), raw.size(), 1) ==
                   static_cast<int>(raw.size());
          }};
}
#endif

#if defined(PLAIT_BENCH_FPZIP)
Coder fpzip() {
  const auto describe = [](FPZ* stream, const RawBlock& block) {
    stream->type = FPZIP_TYPE_FLOAT;
    stream->prec = 0;
    stream->nx = static_cast<int>(block.columns);
    stream->ny = static_cast<int>(block.rows);
    stream->nz = 1;
    stream->nf = 3;
  };
  return {"fpzip",
          [=](const RawBlock& block, Bytes to) {
            const std::vector<float> numbers = by_component(block.raw);
            FPZ* const stream = fpzip_write_to_buffer(to.data(), to.size());
            describe(stream, block);
            const std::size_t size = fpzip_write(stream, numbers.data());
            fpzip_write_close(stream);
            return size;
          },
          [=](Encoded encoded, const RawBlock& block, Bytes raw) {
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
Coder meshoptimizer() {
  constexpr std::size_t kRecord = 12;
  return {"meshoptimizer, zstd 1",
          [](const RawBlock& block, Bytes to) {
            const std::size_t count = block.raw.size() / kRecord;
            std::vector<unsigned char> vertices(meshopt_encodeVertexBufferBound(count, kRecord));
            vertices.resize(meshopt_encodeVertexBuffer(vertices.data(), vertices.size(),
                                                       block.raw.data(), count, kRecord));
            return ZSTD_compress(to.data(), to.size(), vertices.data(), vertices.size(), 1);
          },
          [](Encoded encoded, const RawBlock&, Bytes raw) {
            std::vector<unsigned char> vertices(
                ZSTD_getFrameContentSize(encoded.data(), encoded.size()));
            ZSTD_decompress(vertices.data(), vertices.size(), encoded.data(), encoded.size());
            return meshopt_decodeVertexBuffer(raw.data(), raw.size() / kRecord, kRecord,
                                              vertices.data(), vertices.size()) == 0;
          }};
}
#endif

}  // namespace

#if defined(PLAIT_BENCH_ZFP)
Coder zfp(double tolerance) {
  // One stream for each component, one after another. Returns the size of all, 0 on failure.
  const auto code = [=](bitstream* bits, float* numbers, const RawBlock& block, auto one) {
    zfp_stream* const stream = zfp_stream_open(bits);
    if (tolerance > 0)
      zfp_stream_set_accuracy(stream, tolerance);
    else
      zfp_stream_set_reversible(stream);
    bool done = true;
    for (std::size_t component = 0; component < 3; ++component) {
      zfp_field* const field = zfp_field_2d(numbers + component * block.columns * block.rows,
                                            zfp_type_float, block.columns, block.rows);
      done = one(stream, field) != 0 && done;
      zfp_field_free(field);
    }
    const std::size_t size = zfp_stream_compressed_size(stream);
    zfp_stream_close(stream);
    stream_close(bits);
    return done ? size : 0;
  };
  return {tolerance > 0 ? "zfp, accuracy, 2-D" : "zfp, reversible, 2-D",
          [=](const RawBlock& block, Bytes to) {
            std::vector<float> numbers = by_component(block.raw);
            return code(stream_open(to.data(), to.size()), numbers.data(), block, zfp_compress);
          },
          [=](Encoded encoded, const RawBlock& block, Bytes raw) {
            std::vector<float> numbers(raw.size() / 4);
            // It changes nothing, and reads whole words, so up to seven bytes more.
            bitstream* const bits =
                stream_open(const_cast<std::byte*>(encoded.data()), encoded.size() + 64);
            const bool done = code(bits, numbers.data(), block, zfp_decompress) != 0;
            by_record(numbers, raw);
            return done;
          }};
}
#endif

std::vector<Coder> peer_coders() {
  std::vector<Coder> peers;
#if defined(PLAIT_BENCH_BLOSC)
  peers.push_back(blosc());
#endif
#if defined(PLAIT_BENCH_FPZIP)
  peers.push_back(fpzip());
#endif
#if defined(PLAIT_BENCH_MESHOPTIMIZER)
  peers.push_back(meshoptimizer());
#endif
#if defined(PLAIT_BENCH_ZFP)
  peers.push_back(zfp(0));
#endif
  return peers;
}

}  // namespace plait::bench
