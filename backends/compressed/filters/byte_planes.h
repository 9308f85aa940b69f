// backends/compressed/filters/byte_planes.h: the loops of the filter `shuffle`. Each call uses the
// best instruction set of the processor. All sets write the same bytes. Pinned by
// tests/backends/compressed/filters/single_numbers_test.cpp.
#pragma once

#include <cstddef>

#include "plait/detail/namespace.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Writes byte `plane` of number i to planes[plane * count + i], for `count` numbers of `width`
/// bytes. REQUIRES: width is 2, 4 or 8; the two areas do not overlap.
void split_planes(const std::byte* numbers, std::size_t count, std::size_t width,
                  std::byte* planes);
/// The inverse.
void join_planes(const std::byte* planes, std::size_t count, std::size_t width, std::byte* numbers);

PLAIT_END_NAMESPACE
