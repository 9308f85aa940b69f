// backends/compressed/filters/column_rows.h: the loops of the filter `columns` for whole slots of 1
// to 4 float32. Each call uses the best instruction set of the processor; all sets write the same
// bytes. Pinned by tests/backends/compressed/filters/slot_filters_test.cpp for every instruction
// set.
#pragma once

#include <cstddef>
#include <cstdint>

#include "plait/detail/namespace.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// A whole slot: `side` rows of `side` records, which have `components` numbers each. The stored
/// words of a row are grouped by component.
struct ColumnSlot {
  std::size_t side;
  int components;
};

/// Whether the two functions below take such slots on this processor.
bool has_column_rows(const ColumnSlot& slot);
/// Encodes a slot. `before` has the bits of the first record of the slot before it, and gets those
/// of this one.
void encode_column_rows(const ColumnSlot& slot, const float* numbers, std::uint32_t* words,
                        std::uint32_t* before);
/// The inverse.
void decode_column_rows(const ColumnSlot& slot, const std::uint32_t* words, float* numbers,
                        std::uint32_t* before);

PLAIT_END_NAMESPACE
