// Loops over records whose size is known only when the program runs, compiled for the usual sizes.
#pragma once

#include <array>
#include <cstddef>
#include <utility>

#include "plait/detail/namespace.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Calls work(record), where the type of `record` has this size and no alignment, and returns true.
/// Returns false for a size that records rarely have.
template <class Work>
bool with_record_size(std::size_t bytes, Work work) {
  const auto with_one_of = [&]<std::size_t... kSizes>(std::index_sequence<kSizes...>) {
    return ((bytes == kSizes && (work(std::array<std::byte, kSizes>()), true)) || ...);
  };
  return with_one_of(std::index_sequence<1, 2, 3, 4, 8, 12, 16, 24>());
}

PLAIT_END_NAMESPACE
