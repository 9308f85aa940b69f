// backends/compressed/codecs/packed_groups.h: groups of 16 words of 32 bits, each group in as many
// bits a word as its largest word needs. docs/filters/bitpack.md has the bytes. Each call uses the
// best instruction set of the processor; all sets give the same bytes. Pinned by
// tests/backends/compressed/codecs/codec_test.cpp for every instruction set.
#pragma once

#include <cstddef>
#include <cstdint>

#include "plait/detail/namespace.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

constexpr std::size_t kGroupWords = 16;
constexpr std::uint32_t kMostBits = 32;

/// The bytes of `words` words of a group, `width` bits each.
constexpr std::size_t packed_bytes(std::size_t words, std::uint32_t width) noexcept {
  return (words * width + 7) / 8;
}

/// Writes how many bits the largest word of each group needs, from 0 to 32. The words of a group
/// follow each other, and need no alignment.
void find_widths(const std::byte* words, std::size_t groups, std::uint32_t* widths);
/// Writes the groups one after another, each with as many bits a word as its width says.
void pack_groups(const std::byte* words, std::size_t groups, const std::uint32_t* widths,
                 std::byte* packed);
/// The inverse. REQUIRES: no width is above 32, and `packed` has `bytes` bytes, at least those of
/// all groups.
void unpack_groups(const std::byte* packed, std::size_t bytes, const std::uint32_t* widths,
                   std::size_t groups, std::byte* words);

PLAIT_END_NAMESPACE
