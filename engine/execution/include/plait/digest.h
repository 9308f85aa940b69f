// plait/digest.h: one number computed from all records of a store.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "plait/detail/namespace.h"
#include "plait/progress.h"
#include "plait/store.h"

PLAIT_BEGIN_NAMESPACE

/// A number of 128 bits that the records of a store determine.
struct Digest {
  std::uint64_t high = 0, low = 0;
  friend bool operator==(const Digest&, const Digest&) = default;
  /// 32 hexadecimal digits.
  std::string to_string() const;
};

/// Options of digest().
struct DigestOptions {
  /// Counts only the vertices that this level creates (for the base level, the base vertices). -1:
  /// all vertices.
  int level = -1;
  int threads = 1;  ///< 1 to 1024; 0: all processors; fewer if the budget holds the blocks of fewer
  /// Counts edges of all passes. May begin again from 0 with another total, if the budget holds
  /// fewer levels at once than was tried first.
  ProgressCallback progress = {};
  /// Called once with the threads that are taken. May be empty.
  std::function<void(int threads)> begins = {};
};

/// The sum, modulo 2^128, of one XXH3-128 hash for each base vertex and each slot. The input of a
/// hash is: lower endpoint, higher endpoint and level (three little-endian uint32), the attribute's
/// name, a zero byte, and the decoded bytes. For a base vertex, both endpoints are the vertex and
/// the level is the store's base level. The digest is equal for any backend, codec, block size,
/// budget, executor, thread count and layout.
/// Errors: kInvalidArgument for a level that does not exist; kCorruption; kIo; kBudget; kCancelled.
Digest digest(const Store& store, const DigestOptions& options = {});

PLAIT_END_NAMESPACE
