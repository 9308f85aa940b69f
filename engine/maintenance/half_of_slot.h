// The half of a whole slot that one of its faces has.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>

#include "plait/detail/namespace.h"
#include "plait/extend/edge_index.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Copies it in the frame of this face. `own`: the face is the edge's own. `refinement`: of the
/// slot's level. REQUIRES: `whole` is a whole slot of records of `record_bytes`, and `half` has the
/// bytes of a half one.
inline void copy_half_of_slot(std::span<const std::byte> whole, std::size_t record_bytes,
                              int refinement, bool own, std::span<std::byte> half) {
  const auto n = static_cast<std::size_t>(slot_side(refinement));
  std::byte* to = half.data();
  for (std::size_t row = 0; row < n; ++row)
    for (std::size_t column = 0; column < n - row; ++column, to += record_bytes) {
      const std::size_t at = row * n + column;
      std::copy_n(whole.data() + (own ? at : n * n - 1 - at) * record_bytes, record_bytes, to);
    }
}

PLAIT_END_NAMESPACE
