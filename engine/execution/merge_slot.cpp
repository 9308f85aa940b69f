#if defined(__SSE2__)
#include <immintrin.h>
#endif

#include <algorithm>
#include <cstring>

#include "execution/slot_halves.h"

namespace plait {
namespace {

/// A slot is put together in pieces that stay in the innermost cache, with room for a vector that
/// is stored over the end.
constexpr std::int64_t kPieceBytes = 4096, kVectorBytes = 16;

/// Whole lines bypass the caches; a slot of less than a few would leave parts of lines behind.
constexpr std::int64_t kLineBytes = 64, kLeastStreamed = 8 * kLineBytes;

/// REQUIRES: `to` is aligned to a line, `bytes` a multiple of one.
void stream(const std::byte* from, std::int64_t bytes, std::byte* to) {
#if defined(__SSE2__)
  for (; bytes > 0; bytes -= kVectorBytes, from += kVectorBytes, to += kVectorBytes)
    _mm_stream_si128(reinterpret_cast<__m128i*>(to),
                     _mm_load_si128(reinterpret_cast<const __m128i*>(from)));
#else
  std::memcpy(to, from, static_cast<std::size_t>(bytes));
#endif
}

/// Reads and writes up to a vector beyond `bytes`: no branch on what is left, no call.
void copy_run(const std::byte* from, std::int64_t bytes, std::byte* to) {
#if defined(__SSE2__)
  for (; bytes > 0; bytes -= kVectorBytes, from += kVectorBytes, to += kVectorBytes)
    _mm_storeu_si128(reinterpret_cast<__m128i*>(to),
                     _mm_loadu_si128(reinterpret_cast<const __m128i*>(from)));
#else
  std::memcpy(to, from, static_cast<std::size_t>(bytes));
#endif
}

}  // namespace

void merge_slot(std::size_t record_bytes, int level, const std::byte* own, const std::byte* other,
                bool streaming, std::byte* slot) {
  const std::int64_t n = slot_side(level), record = static_cast<std::int64_t>(record_bytes);
  if (!other) {
    std::memcpy(slot, own, slot_records(level, true) * record_bytes);
    return;
  }
  if (n * record > kPieceBytes) {
    for (std::int64_t row = 0; row < n; ++row) {
      const std::int64_t own_bytes = (n - row) * record, other_bytes = row * record;
      std::memcpy(slot, own, static_cast<std::size_t>(own_bytes));
      std::memcpy(slot + own_bytes, other, static_cast<std::size_t>(other_bytes));
      own += own_bytes;
      other += other_bytes;
      slot += own_bytes + other_bytes;
    }
    return;
  }
  alignas(64) std::byte piece[kPieceBytes + kVectorBytes];
  std::byte* end = piece;
  const auto hand_over = [&] {
    const std::int64_t bytes = end - piece;
    if (streaming && bytes >= kLeastStreamed && bytes % kLineBytes == 0 &&
        reinterpret_cast<std::uintptr_t>(slot) % kLineBytes == 0)
      stream(piece, bytes, slot);
    else
      std::memcpy(slot, piece, static_cast<std::size_t>(bytes));
    slot += bytes;
    end = piece;
  };
  for (std::int64_t row = 0; row < n; ++row) {
    if (end - piece + n * record > kPieceBytes) hand_over();
    const std::int64_t own_bytes = (n - row) * record, other_bytes = row * record;
    copy_run(own, own_bytes, end);
    copy_run(other, other_bytes, end + own_bytes);
    own += own_bytes;
    other += other_bytes;
    end += own_bytes + other_bytes;
  }
  hand_over();
}

void finish_streaming() {
#if defined(__SSE2__)
  _mm_sfence();
#endif
}

}  // namespace plait
