// backends/compressed/filters/byte_planes.h: the loops of the filters that move bytes. Each call
// uses the best instruction set of the processor. All sets write the same bytes. Pinned by
// tests/backends/compressed/filters/byte_planes_test.cpp.
#pragma once

#include <cstddef>

#include "plait/namespace.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Writes byte `plane` of number i to planes[plane * count + i], for `count` numbers of `width`
/// bytes. REQUIRES: width is 2, 4 or 8; the two areas do not overlap.
void split_planes(const std::byte* numbers, std::size_t count, std::size_t width,
                  std::byte* planes);
/// The inverse.
void join_planes(const std::byte* planes, std::size_t count, std::size_t width, std::byte* numbers);

/// Writes to[i] = from[i] - from[i - distance], modulo 256; the first `distance` bytes are copied.
/// REQUIRES: distance >= 1; the two areas do not overlap.
void byte_differences(const std::byte* from, std::size_t count, std::size_t distance,
                      std::byte* to);
/// The inverse: to[i] = from[i] + to[i - distance].
void byte_sums(const std::byte* from, std::size_t count, std::size_t distance, std::byte* to);

PLAIT_END_NAMESPACE
