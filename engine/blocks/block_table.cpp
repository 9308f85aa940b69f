// The checksum of a block (all integers little-endian, || joins bytes):
//
//   level seed = XXH3-64(store UUID (16 bytes) || attribute (4 bytes) || level (4 bytes))
//   block seed = XXH3-64(block number (8 bytes)), seed = level seed
//   checksum   = XXH3-64(stored bytes), seed = block seed
//
// Pinned by tests/engine/blocks/block_table_test.cpp.
#include "plait/extend/block_table.h"

#include <fmt/format.h>
#include <xxhash.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

void put_little_endian(std::span<std::byte> into, std::uint64_t value) {
  for (std::byte& byte : into) {
    byte = static_cast<std::byte>(value & 0xff);
    value >>= 8;
  }
}

bool all_zeros(std::span<const std::byte> bytes) {
  return std::all_of(bytes.begin(), bytes.end(), [](std::byte b) { return b == std::byte{0}; });
}

}  // namespace

BlockTable::BlockTable(const StoreUuid& store, std::uint32_t attribute, int level,
                       std::uint64_t blocks, std::uint64_t first_number)
    : first_number_(first_number), attribute_(attribute), level_(level), entries_(blocks) {
  std::array<std::byte, 24> identity;
  std::copy(store.begin(), store.end(), identity.begin());
  put_little_endian(std::span(identity).subspan(16, 4), attribute);
  put_little_endian(std::span(identity).subspan(20, 4), static_cast<std::uint64_t>(level));
  seed_ = XXH3_64bits(identity.data(), identity.size());
}

BlockTable::BlockTable(const StoreUuid& store, std::uint32_t attribute, int level,
                       std::shared_ptr<StoredEntries> stored)
    : BlockTable(store, attribute, level, std::uint64_t{0}) {
  stored_ = std::move(stored);
}

BlockTable BlockTable::part(std::uint64_t first, std::uint64_t count) const {
  BlockTable result;
  result.seed_ = seed_;
  result.first_number_ = first_number_ + first;
  result.attribute_ = attribute_;
  result.level_ = level_;
  result.generation_ = generation_;
  result.entries_.reserve(count);
  for (std::uint64_t block = first; block < first + count; ++block)
    result.entries_.push_back((*this)[block]);
  return result;
}

std::uint64_t BlockTable::checksum(std::uint64_t block, std::span<const std::byte> stored) const {
  std::array<std::byte, 8> number;
  put_little_endian(number, first_number_ + block);
  const std::uint64_t block_seed = XXH3_64bits_withSeed(number.data(), number.size(), seed_);
  return XXH3_64bits_withSeed(stored.data(), stored.size(), block_seed);
}

void BlockTable::seal(std::uint64_t block, std::uint64_t offset, BlockEncoding encoding,
                      std::span<const std::byte> stored) {
  if (stored.size() > std::numeric_limits<std::uint32_t>::max())
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("seal level {} block {}: expected at most {} stored bytes, found {}",
                            level_, first_number_ + block,
                            std::numeric_limits<std::uint32_t>::max(), stored.size()));
  entries_[block] = {offset, static_cast<std::uint32_t>(stored.size()), encoding, 0,
                     checksum(block, stored)};
}

void BlockTable::seal_predicted(std::uint64_t block, std::span<const std::byte> raw) {
  entries_[block] = {0, 0, BlockEncoding::kPredicted, 0, checksum(block, raw)};
}

void BlockTable::mark_written(std::uint64_t block, std::uint64_t offset, std::uint64_t bytes) {
  entries_[block] = {offset, static_cast<std::uint32_t>(bytes), BlockEncoding::kRaw, 0, 0};
}

bool BlockTable::matches(std::uint64_t block, std::span<const std::byte> stored) const {
  const BlockEntry& entry = (*this)[block];
  if (entry.encoding == BlockEncoding::kNeverWritten) return all_zeros(stored);
  if (entry.encoding != BlockEncoding::kPredicted && stored.size() != entry.stored_bytes)
    return false;
  return checksum(block, stored) == entry.checksum;
}

void BlockTable::check(std::uint64_t block, std::span<const std::byte> stored,
                       const std::filesystem::path& file) const {
  if (matches(block, stored)) return;
  const BlockEntry& entry = (*this)[block];
  if (entry.encoding == BlockEncoding::kPredicted)
    throw Error(ErrorCode::kCorruption,
                fmt::format("read {}: attribute {} level {} block {}: made again, "
                            "it has checksum {:016x}, expected {:016x}",
                            file.native(), attribute_, level_, first_number_ + block,
                            checksum(block, stored), entry.checksum))
        .about(file);
  const std::string place =
      fmt::format("read {}: attribute {} level {} block {} at byte {}", file.native(), attribute_,
                  level_, first_number_ + block, entry.offset);
  if (entry.encoding == BlockEncoding::kNeverWritten)
    throw Error(ErrorCode::kCorruption,
                place + ": expected zeros in a block never written, found other bytes")
        .about(file, entry.offset);
  if (stored.size() != entry.stored_bytes)
    throw Error(ErrorCode::kCorruption, fmt::format("{}: expected {} stored bytes, found {}", place,
                                                    entry.stored_bytes, stored.size()))
        .about(file, entry.offset);
  throw Error(ErrorCode::kCorruption, fmt::format("{}: expected checksum {:016x}, found {:016x}",
                                                  place, entry.checksum, checksum(block, stored)))
      .about(file, entry.offset);
}

PLAIT_END_NAMESPACE
