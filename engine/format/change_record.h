// A record of the change log changes.G: what a small commit changed. Byte table: docs/format.md,
// "Change log". Blocks and pieces of base records come before the record that names them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "format/manifest.h"
#include "plait/extend/file.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// The most records between a version that has a file of its own and the newest one: opening reads
/// them all.
inline constexpr std::uint64_t kMostChangeRecords = 256;
/// The size of the pieces in which base records are compared and written.
inline constexpr std::uint64_t kPieceBytes = 4096;
/// Blocks, pieces and records begin at multiples of it.
inline constexpr std::uint64_t kLogAlignment = 4096;

constexpr std::uint64_t log_aligned(std::uint64_t bytes) {
  return (bytes + kLogAlignment - 1) / kLogAlignment * kLogAlignment;
}

/// A raw block. Files contain this struct byte for byte.
struct ChangedBlock {
  std::uint32_t attribute = 0;  ///< its number
  std::uint32_t level = 0;
  std::uint64_t block = 0;
  std::uint64_t offset = 0;    ///< in the log
  std::uint64_t checksum = 0;  ///< as in BlockEntry

  friend bool operator==(const ChangedBlock&, const ChangedBlock&) = default;
};
static_assert(sizeof(ChangedBlock) == 32);

/// Bytes of an attribute's base records. Files contain this struct byte for byte.
struct ChangedRecords {
  std::uint32_t attribute = 0, reserved = 0;
  std::uint64_t first = 0, bytes = 0;
  std::uint64_t offset = 0;    ///< in the log
  std::uint64_t checksum = 0;  ///< of these bytes

  friend bool operator==(const ChangedRecords&, const ChangedRecords&) = default;
};
static_assert(sizeof(ChangedRecords) == 40);

struct ChangeRecord {
  std::uint64_t version = 0;
  std::uint64_t before = 0, before_checksum = 0;  ///< the record before, in LogPlace's terms
  std::vector<ChangedBlock> blocks;
  std::vector<ChangedRecords> records;
};

std::vector<std::uint64_t> checksums_of_pieces(std::span<const std::byte> records);

/// The bytes of a record; the last eight are their checksum.
std::vector<std::byte> encode_change_record(const ChangeRecord& record);

/// Reads the records from version `manifest.described` + 1 to the newest one. A record has at most
/// `most_entries` blocks and pieces, so that a forged one takes no more memory. Errors: kCorruption
/// (the message names file, offset, expected and found); kIo.
std::vector<ChangeRecord> read_change_records(const File& log, const Manifest& manifest,
                                              std::uint64_t most_entries);

PLAIT_END_NAMESPACE
