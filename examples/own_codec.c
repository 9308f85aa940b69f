/* A plug-in in C: the codec x-runs, which shortens runs of equal bytes, and the filter x-delta,
 * which makes such runs out of numbers that change slowly. Any C compiler builds it, without
 * plait's library:
 *
 *   cc -std=c11 -shared -fPIC own_codec.c -o own_codec.so $(pkg-config --cflags plait)
 *   plait subdivide mesh.ply s.plait --levels 4 --backend compressed \
 *     --plugin ./own_codec.so --compress x-delta+shuffle,x-runs
 *
 * An encoded block is a sequence of: a byte n below 128 and n + 1 bytes as they are; or a byte n
 * from 128 on and one byte that stands for n - 126 of its kind (PackBits, Apple 1996). */
#include <string.h>

#include "plait/extend/plugin.h"

static size_t bound(const void* state, size_t raw_bytes) {
  (void)state;
  return raw_bytes + raw_bytes / 128 + 1;
}

static size_t run_at(const uint8_t* at, const uint8_t* end) {
  size_t run = 1;
  while (run < 129 && at + run < end && at[run] == at[0]) ++run;
  return run;
}

static size_t compress(void* state, const void* raw, size_t raw_bytes, void* into,
                       size_t into_bytes) {
  const uint8_t* from = raw;
  const uint8_t* const end = from + raw_bytes;
  uint8_t* to = into;
  uint8_t* const limit = to + into_bytes;
  (void)state;
  while (from < end) {
    const size_t run = run_at(from, end);
    if (run > 1) {
      if (limit - to < 2) return 0;
      *to++ = (uint8_t)(run + 126);
      *to++ = *from;
      from += run;
      continue;
    }
    size_t count = 1; /* of bytes up to the next run */
    while (count < 128 && from + count < end && run_at(from + count, end) < 3) ++count;
    if ((size_t)(limit - to) < count + 1) return 0;
    *to++ = (uint8_t)(count - 1);
    memcpy(to, from, count);
    to += count;
    from += count;
  }
  return (size_t)(to - (uint8_t*)into);
}

static int32_t decompress(void* state, const void* stored, size_t stored_bytes, void* raw,
                          size_t raw_bytes) {
  const uint8_t* from = stored;
  const uint8_t* const end = from + stored_bytes;
  uint8_t* to = raw;
  size_t left = raw_bytes;
  (void)state;
  while (end - from >= 2) {
    const int is_run = *from >= 128;
    const size_t count = is_run ? *from - 126u : *from + 1u;
    const size_t stored_count = is_run ? 1 : count;
    ++from;
    if (count > left || stored_count > (size_t)(end - from)) return 1;
    if (is_run) memset(to, *from, count);
    if (!is_run) memcpy(to, from, count);
    from += stored_count;
    to += count;
    left -= count;
  }
  return from == end && left == 0 ? 0 : 1;
}

static void encode(const void* state, const void* raw, void* filtered, size_t bytes,
                   size_t component_bytes) {
  const uint8_t* from = raw;
  uint8_t* to = filtered;
  (void)state;
  for (size_t i = 0; i < bytes; ++i)
    to[i] = (uint8_t)(from[i] - (i < component_bytes ? 0 : from[i - component_bytes]));
}

static void decode(const void* state, const void* filtered, void* raw, size_t bytes,
                   size_t component_bytes) {
  const uint8_t* from = filtered;
  uint8_t* to = raw;
  (void)state;
  for (size_t i = 0; i < bytes; ++i)
    to[i] = (uint8_t)(from[i] + (i < component_bytes ? 0 : to[i - component_bytes]));
}

int32_t plait_plugin_v1(const plait_host* host) {
  const plait_codec codec = {
      sizeof codec, "x-runs", "runs of equal bytes", NULL, NULL, NULL, bound, compress, decompress};
  const plait_filter filter = {sizeof filter, "x-delta", "differences", NULL, NULL, encode, decode};
  return host->add_codec(host, &codec) || host->add_filter(host, &filter);
}
