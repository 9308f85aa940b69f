// plait/digest.h: one number for a store's content, whatever holds it.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "plait/store.h"

namespace plait {

struct Digest {
  std::uint64_t high = 0, low = 0;
  friend bool operator==(const Digest&, const Digest&) = default;
  /// 32 hexadecimal digits.
  std::string to_string() const;
};

struct DigestOptions {
  /// Only what is born at this level (the base level: the base records); -1: everything.
  int level = -1;
  int threads = 1;
  std::function<bool(std::uint64_t done, std::uint64_t total)> proceed = {};  ///< false cancels
};

/// The sum modulo 2^128, over base vertices and slots, of XXH3-128(lower endpoint, higher endpoint,
/// level: three little-endian uint32; attribute name, a zero byte; the decoded bytes). A base
/// vertex has itself as both endpoints and the store's base level. Equal for any backend, codec,
/// block size, budget, executor, thread count and layout.
/// Errors: kInvalidArgument for a level that is not there; kCorruption; kIo; kCancelled.
Digest digest(Store& store, const DigestOptions& options = {});

}  // namespace plait
