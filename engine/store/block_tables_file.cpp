#include "store/block_tables_file.h"

#include <fmt/format.h>

#include <cstdint>
#include <cstring>
#include <utility>

#include "store/byte_order.h"

namespace plait {
namespace {

constexpr char kMagic[] = "plaitblk";
constexpr std::size_t kHeaderBytes = 16;
constexpr std::uint32_t kVersion = 1;

bool is_in_range(const BlockEntry& entry, std::uint64_t block_bytes) {
  if (entry.offset > (std::uint64_t{1} << 62)) return false;
  switch (entry.encoding) {
    case BlockEncoding::kNeverWritten:
      return entry.offset == 0 && entry.stored_bytes == 0 && entry.checksum == 0;
    case BlockEncoding::kRaw:
      return entry.stored_bytes == block_bytes;
    case BlockEncoding::kEncoded:
      return entry.stored_bytes > 0 && entry.stored_bytes < block_bytes;
  }
  return false;
}

}  // namespace

std::vector<std::byte> encode_tables(std::span<const BlockTable* const> tables) {
  std::vector<std::byte> bytes(kHeaderBytes);
  std::memcpy(bytes.data(), kMagic, 8);
  save(std::span(bytes), 8, kVersion);
  for (const BlockTable* const table : tables) {
    const auto entries = std::as_bytes(table->entries());
    bytes.insert(bytes.end(), entries.begin(), entries.end());
  }
  return bytes;
}

BlockTablesReader::BlockTablesReader(std::span<const std::byte> bytes, std::filesystem::path path)
    : rest_(bytes), path_(std::move(path)) {
  if (rest_.size() < kHeaderBytes || std::memcmp(rest_.data(), kMagic, 8) != 0 ||
      load<std::uint32_t>(rest_, 8) != kVersion)
    throw refuse("no header of block tables");
  rest_ = rest_.subspan(kHeaderBytes);
}

std::vector<BlockEntry> BlockTablesReader::next_level(const LevelGeometry& geometry) {
  if (rest_.size() / sizeof(BlockEntry) < geometry.block_count())
    throw refuse("it ends before its last level");
  std::vector<BlockEntry> entries(geometry.block_count());
  const std::size_t bytes = entries.size() * sizeof(BlockEntry);
  if (bytes > 0) std::memcpy(entries.data(), rest_.data(), bytes);
  rest_ = rest_.subspan(bytes);
  for (std::uint64_t block = 0; block < entries.size(); ++block)
    if (!is_in_range(entries[block], geometry.block_bytes(block)))
      throw refuse(fmt::format("the table entry of block {} is out of range", block));
  return entries;
}

void BlockTablesReader::finish() const {
  if (!rest_.empty()) throw refuse("it goes on after its last level");
}

Error BlockTablesReader::refuse(std::string_view reason) const {
  return {ErrorCode::kCorruption, fmt::format("open {}: {}", path_.native(), reason)};
}

}  // namespace plait
