// plait/verify.h: reads everything that a store has committed and checks it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "plait/namespace.h"
#include "plait/store.h"

PLAIT_BEGIN_NAMESPACE

/// A block whose stored bytes have another checksum than its entry in the block table, or which
/// cannot be read.
struct DamagedBlock {
  std::string attribute;
  int level = 0;
  std::uint64_t block = 0;
  std::uint64_t file_offset = 0;
  EdgeId first_edge = 0, edge_after = 0;  ///< [first_edge, edge_after)
  std::string reason;
};

/// What verify() found.
struct VerifyReport {
  std::uint64_t blocks = 0, bytes = 0;  ///< read and checked; raw bytes
  std::uint64_t never_written = 0;      ///< blocks that read as zeros
  std::vector<DamagedBlock> damaged;    ///< at most 1,000; see damaged_count
  std::uint64_t damaged_count = 0;
};

/// Reads every block of every level through its backend, one after another, past the pager.
/// Damage, also a block that the operating system fails to read, goes into the report; only what
/// keeps it from going on is thrown (kCancelled, kOutOfMemory; kIo while flushing).
/// `damaged` is told of every bad block, also of those that the report only counts. What
/// Store::open refuses already is found by check_store (plait/check_store.h).
VerifyReport verify(
    Store& store, const std::function<bool(std::uint64_t done, std::uint64_t total)>& proceed = {},
    const std::function<void(const BlockAddress&)>& damaged = {});

PLAIT_END_NAMESPACE
