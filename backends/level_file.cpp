#include "level_file.h"

#include <fcntl.h>
#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <limits>

#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

void check_fixed_entries(const LevelSpec& level) {
  const LevelGeometry& geometry = level.geometry;
  for (std::uint64_t block = 0; block < geometry.block_count(); ++block) {
    const BlockEntry& entry = level.table[block];
    const std::uint64_t offset = level.first_byte + geometry.block_offset(block);
    if (entry.encoding == BlockEncoding::kNeverWritten || entry.file != kLevelFile) continue;
    if (entry.encoding == BlockEncoding::kRaw && entry.offset == offset &&
        entry.stored_bytes == geometry.block_bytes(block))
      continue;
    throw Error(
        ErrorCode::kCorruption,
        fmt::format("open {}: block {}: expected {} raw bytes at byte {}, found {} bytes "
                    "of encoding {} at byte {}",
                    level.path().native(), block, geometry.block_bytes(block), offset,
                    entry.stored_bytes, static_cast<std::uint32_t>(entry.encoding), entry.offset));
  }
}

}  // namespace

std::uint64_t fixed_file_bytes(const LevelGeometry& geometry) {
  return (geometry.total_bytes() + kPageBytes - 1) / kPageBytes * kPageBytes;
}

File open_fixed_file(const LevelSpec& level) {
  // The block table counts a block's stored bytes in 32 bits.
  check_level(level, std::numeric_limits<std::uint32_t>::max());
  const std::uint64_t bytes = level.first_byte + fixed_file_bytes(level.geometry);
  if (level.mode != OpenMode::kCreate) check_fixed_entries(level);
  const bool is_added = level.mode == OpenMode::kCreate && level.first_byte > 0;
  File file(level.directory, level.name, is_added ? OpenMode::kReadWrite : level.mode);
  if (level.mode != OpenMode::kCreate) {
    const std::uint64_t found = file.size();
    if (level.shares_file ? found < bytes : found != bytes)
      throw Error(ErrorCode::kCorruption,
                  fmt::format("open {}: expected {}{} bytes, found {}", level.path().native(),
                              level.shares_file ? "at least " : "", bytes, found))
          .about(level.path());
    return file;
  }
  try {
    file.resize(bytes);
    file.preallocate(bytes);
  } catch (...) {
    if (!is_added) level.directory.remove_if_possible(level.name);
    throw;
  }
  return file;
}

void check_level(const LevelSpec& level, std::uint64_t max_block_bytes) {
  if (level.table.size() != level.geometry.block_count())
    throw Error(
        ErrorCode::kInvalidArgument,
        fmt::format("open {}: expected a table of {} blocks, found {}", level.path().native(),
                    level.geometry.block_count(), level.table.size()));
  if (level.geometry.max_block_bytes() > max_block_bytes)
    throw Error(
        ErrorCode::kInvalidArgument,
        fmt::format("open {}: expected blocks of at most {} bytes, found {}", level.path().native(),
                    max_block_bytes, level.geometry.max_block_bytes()));
}

void check_request(const LevelGeometry& geometry, BlockRange blocks, std::size_t span_bytes) {
  if (blocks.first > geometry.block_count() || blocks.count > geometry.block_count() - blocks.first)
    throw Error(
        ErrorCode::kInvalidArgument,
        fmt::format("access blocks of a level: expected blocks below {}, found {} blocks from {}",
                    geometry.block_count(), blocks.count, blocks.first));
  const std::uint64_t expected = geometry.range_bytes(blocks.first, blocks.count);
  if (span_bytes != expected)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("access blocks {} to {} of a level: expected {} bytes, found {}",
                            blocks.first, blocks.first + blocks.count, expected, span_bytes));
}

void check_writable(const File& file, OpenMode mode) {
  if (mode == OpenMode::kRead)
    throw Error(ErrorCode::kBadState,
                fmt::format("write {}: the level was opened for reading", file.path().native()));
}

ByteRange fixed_bytes(const LevelGeometry& geometry, BlockRange blocks,
                      std::uint64_t first_byte) noexcept {
  const std::uint64_t first = std::min(blocks.first, geometry.block_count());
  const std::uint64_t count = std::min(blocks.count, geometry.block_count() - first);
  return {first_byte + geometry.block_offset(first), geometry.range_bytes(first, count)};
}

void seal_raw(const LevelGeometry& geometry, BlockTable& table, BlockRange blocks,
              std::span<const std::byte> from, std::uint64_t first_byte) {
  for (std::uint64_t block = blocks.first; block < blocks.first + blocks.count; ++block) {
    const std::uint64_t bytes = geometry.block_bytes(block);
    table.seal(block, first_byte + geometry.block_offset(block), BlockEncoding::kRaw,
               from.first(bytes));
    from = from.subspan(bytes);
  }
}

void check_raw(const LevelGeometry& geometry, const BlockTable& table, BlockRange blocks,
               std::span<std::byte> into, const std::filesystem::path& path) {
  zero_unwritten(geometry, table, blocks, into);
  for (std::uint64_t block = blocks.first; block < blocks.first + blocks.count; ++block) {
    const std::span<std::byte> raw = into.first(geometry.block_bytes(block));
    if (table[block].encoding != BlockEncoding::kNeverWritten) table.check(block, raw, path);
    into = into.subspan(raw.size());
  }
}

void zero_unwritten(const LevelGeometry& geometry, const BlockTable& table, BlockRange blocks,
                    std::span<std::byte> into) {
  for (std::uint64_t block = blocks.first; block < blocks.first + blocks.count; ++block) {
    const std::span<std::byte> raw = into.first(geometry.block_bytes(block));
    if (table[block].encoding == BlockEncoding::kNeverWritten)
      std::fill(raw.begin(), raw.end(), std::byte{0});
    into = into.subspan(raw.size());
  }
}

void copy_unless_same(const std::byte* from, std::byte* to, std::size_t bytes) {
  if (from != to && bytes > 0) std::memcpy(to, from, bytes);
}

void start_writing(const File& file, ByteRange bytes) {
  if (bytes.count == 0) return;  // sync_file_range takes 0 as the whole file
  if (::sync_file_range(file.descriptor(), static_cast<off_t>(bytes.first),
                        static_cast<off_t>(bytes.count), SYNC_FILE_RANGE_WRITE) == 0)
    return;
  // Other errors say that the kernel, its file system or a filter of system calls has no such call,
  // which only begins early what a sync does.
  if (errno == EIO || errno == ENOSPC || errno == EDQUOT)
    throw system_error("write", file.path().native(), errno);
}

void advise_sequential(const File& file) noexcept {
  ::posix_fadvise(file.descriptor(), 0, 0, POSIX_FADV_SEQUENTIAL);  // 0 bytes: the whole file
}

PLAIT_END_NAMESPACE
