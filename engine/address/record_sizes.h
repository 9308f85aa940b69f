// Loops over records whose size is known only when the program runs, compiled for the usual sizes.
#pragma once

#include <array>
#include <cstddef>

#include "plait/detail/namespace.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Calls work(record), where the type of `record` has this size and no alignment, and returns true.
/// Returns false for a size that records rarely have.
template <class Work>
bool with_record_size(std::size_t bytes, Work work) {
  switch (bytes) {
    case 1:
      work(std::array<std::byte, 1>());
      return true;
    case 2:
      work(std::array<std::byte, 2>());
      return true;
    case 3:
      work(std::array<std::byte, 3>());
      return true;
    case 4:
      work(std::array<std::byte, 4>());
      return true;
    case 8:
      work(std::array<std::byte, 8>());
      return true;
    case 12:
      work(std::array<std::byte, 12>());
      return true;
    case 16:
      work(std::array<std::byte, 16>());
      return true;
    case 24:
      work(std::array<std::byte, 24>());
      return true;
    default:
      return false;
  }
}

PLAIT_END_NAMESPACE
