#include "format/version_file.h"

#include <fmt/format.h>

#include <array>
#include <cstdint>
#include <cstring>
#include <string>
#include <utility>

#include "format/byte_order.h"
#include "format/change_record.h"
#include "format/checksum.h"
#include "format/version_description.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr char kVersionMagic[] = "plaitver";
constexpr std::size_t kVersionHeaderBytes = 32;
constexpr std::uint32_t kVersionFormat = 1;

bool is_in_range(const BlockEntry& entry, std::uint64_t block_bytes, std::uint64_t log_bytes) {
  if (entry.offset > (std::uint64_t{1} << 62)) return false;
  if (entry.file == kLogFile)
    return entry.encoding == BlockEncoding::kRaw && entry.stored_bytes == block_bytes &&
           entry.offset % kLogAlignment == 0 && entry.offset <= log_bytes &&
           block_bytes <= log_bytes - entry.offset;
  if (entry.file != kLevelFile) return false;
  switch (entry.encoding) {
    case BlockEncoding::kNeverWritten:
      return entry.offset == 0 && entry.stored_bytes == 0 && entry.checksum == 0;
    case BlockEncoding::kRaw:
      return entry.stored_bytes == block_bytes;
    case BlockEncoding::kEncoded:
      return entry.stored_bytes > 0 && entry.stored_bytes < block_bytes;
    case BlockEncoding::kPredicted:
      return entry.offset == 0 && entry.stored_bytes == 0;
  }
  return false;
}

}  // namespace

std::vector<std::byte> encode_version_file(std::span<const std::byte> description,
                                           std::span<const BlockTable* const> tables) {
  std::vector<std::byte> bytes(kVersionHeaderBytes);
  std::memcpy(bytes.data(), kVersionMagic, 8);
  save(std::span(bytes), 8, kVersionFormat);
  save(std::span(bytes), 16, std::uint64_t{description.size()});
  save(std::span(bytes), 24, checksum_of(description));
  bytes.insert(bytes.end(), description.begin(), description.end());
  for (const BlockTable* const table : tables) {
    const auto entries = std::as_bytes(table->entries());
    bytes.insert(bytes.end(), entries.begin(), entries.end());
  }
  return bytes;
}

std::vector<std::byte> read_description(const File& file) {
  const auto refuse = [&](const std::string& reason) {
    return Error(ErrorCode::kCorruption, fmt::format("open {}: {}", file.path().native(), reason))
        .about(file.path());
  };
  const std::uint64_t size = file.size();
  if (size < kVersionHeaderBytes)
    throw refuse(fmt::format("{} bytes, expected at least {}", size, kVersionHeaderBytes));
  std::array<std::byte, kVersionHeaderBytes> header{};
  file.read_at(0, header);
  if (std::memcmp(header.data(), kVersionMagic, 8) != 0 ||
      load<std::uint32_t>(header, 8) != kVersionFormat)
    throw refuse("expected the header of a version");
  const auto bytes = load<std::uint64_t>(header, 16), checksum = load<std::uint64_t>(header, 24);
  if (bytes > size - kVersionHeaderBytes || bytes > kMaxDescriptionBytes)
    throw refuse(
        fmt::format("expected a description of at most {} bytes in the {} of the file, "
                    "found one of {}",
                    kMaxDescriptionBytes, size, bytes));
  std::vector<std::byte> description(bytes);
  file.read_at(kVersionHeaderBytes, description);
  if (const std::uint64_t found = checksum_of(description); found != checksum)
    throw refuse(
        fmt::format("the description has checksum {:016x}, expected {:016x}", found, checksum));
  return description;
}

BlockTablesReader::BlockTablesReader(std::span<const std::byte> bytes, std::filesystem::path path)
    : rest_(bytes), path_(std::move(path)) {}

std::vector<BlockEntry> BlockTablesReader::next_level(const LevelGeometry& geometry,
                                                      std::uint64_t log_bytes) {
  if (rest_.size() / sizeof(BlockEntry) < geometry.block_count())
    throw refuse("the block tables end before the last level");
  std::vector<BlockEntry> entries(geometry.block_count());
  const std::size_t bytes = entries.size() * sizeof(BlockEntry);
  if (bytes > 0) std::memcpy(entries.data(), rest_.data(), bytes);
  rest_ = rest_.subspan(bytes);
  for (std::uint64_t block = 0; block < entries.size(); ++block)
    if (!is_in_range(entries[block], geometry.block_bytes(block), log_bytes))
      throw refuse(fmt::format("the table entry of block {} is out of range", block));
  return entries;
}

void BlockTablesReader::finish() const {
  if (!rest_.empty()) throw refuse("there are bytes after the block table of the last level");
}

Error BlockTablesReader::refuse(std::string_view reason) const {
  return {ErrorCode::kCorruption, fmt::format("open {}: {}", path_.native(), reason)};
}

PLAIT_END_NAMESPACE
