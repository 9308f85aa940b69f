// backends/compressed/filters/wide_slots.h: decodes several slots side by side, several in each
// vector. Decoding a record inside a slot has to wait for the one to its left
// (predicting_filter.h), so a processor is busy only with many slots at once. For records of three
// or four words of 32 bits. Each call uses the best instruction set of the processor; all sets
// write the same bytes. Pinned by tests/backends/compressed/filters/slot_filters_test.cpp for every
// instruction set.
#pragma once

#include <cstddef>
#include <cstdint>

#include "plait/namespace.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

enum class SlotRule : std::uint8_t { kLorenzoFloat, kLorenzoInteger, kParallelogram };

/// Whole slots whose first records are decoded.
struct WideSlots {
  const std::byte* const* from;
  std::byte* const* to;
  std::size_t side, stride;  ///< rows; bytes from one record to the next
  int components;            ///< 3 or 4
  std::byte* row;  ///< room for `side` records of wide_slots_at_once() slots, 16 bytes each
};

constexpr std::size_t kMostWideSlots = 16;
/// How many slots decode_wide_slots() decodes, at most kMostWideSlots; 0 if the processor has no
/// vectors.
std::size_t wide_slots_at_once();
void decode_wide_slots(SlotRule rule, const WideSlots& slots);

PLAIT_END_NAMESPACE
