// backends/level_file.h: functions that several backends use: they open a level's file, check a
// request, and seal and verify raw blocks of fixed-offset levels. In a fixed-offset level,
// LevelGeometry gives the offset of each block in the file.
//
// The file of a fixed-offset level is the level's raw bytes, padded with zeros to a multiple of
// kPageBytes. In a shared file, such levels come one after another.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "plait/extend/backend.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

constexpr std::uint64_t kPageBytes = 4096;

/// The bytes that a fixed-offset level takes of its file.
std::uint64_t fixed_file_bytes(const LevelGeometry& geometry);

/// Creates or opens the level's file. A new file gets its full size, and its space is allocated on
/// the disk; if that fails, the file is removed. A shared file grows by the level, and stays. For
/// an existing file, the function checks its size and the entry of every block that it has. Errors:
/// kCorruption, kIo, kNoSpace; kInvalidArgument as check_level.
File open_fixed_file(const LevelSpec& level);

/// Throws kInvalidArgument if the table does not have one entry per block of the level, or if a
/// block is larger than `max_block_bytes`.
void check_level(const LevelSpec& level, std::uint64_t max_block_bytes);

/// Throws kInvalidArgument if the level does not have these blocks, or if `span_bytes` is not their
/// size.
void check_request(const LevelGeometry& geometry, BlockRange blocks, std::size_t span_bytes);

/// Throws kBadState for a level that was opened for reading.
void check_writable(const File& file, OpenMode mode);

/// A range of bytes in the file of a fixed-offset level.
struct ByteRange {
  std::uint64_t first = 0, count = 0;
};
/// `first_byte` is where the level begins.
ByteRange fixed_bytes(const LevelGeometry& geometry, BlockRange blocks,
                      std::uint64_t first_byte = 0) noexcept;

/// Seals the raw bytes `from` of these blocks at the geometry's offsets from `first_byte` on.
void seal_raw(const LevelGeometry& geometry, BlockTable& table, BlockRange blocks,
              std::span<const std::byte> from, std::uint64_t first_byte = 0);

/// Verifies the raw bytes `into` of these blocks. Fills the bytes of never-written blocks with
/// zeros.
/// Errors: kCorruption naming `path`.
void check_raw(const LevelGeometry& geometry, const BlockTable& table, BlockRange blocks,
               std::span<std::byte> into, const std::filesystem::path& path);

/// Fills the bytes of the never-written blocks among `blocks` with zeros.
void zero_unwritten(const LevelGeometry& geometry, const BlockTable& table, BlockRange blocks,
                    std::span<std::byte> into);

/// For backends whose address() returns addresses. If `from` and `to` are the same address, nothing
/// is copied.
void copy_unless_same(const std::byte* from, std::byte* to, std::size_t bytes);

/// Makes the system begin to write these bytes from the page cache to the disk, and does not wait.
/// Uses sync_file_range, because msync(MS_ASYNC) does nothing on Linux. If the file system does not
/// support it, the bytes reach the disk with sync().
/// Errors: kIo naming the file.
void start_writing(const File& file, ByteRange bytes);

/// Tells the system that the file is read in order: it reads ahead farther.
void advise_sequential(const File& file) noexcept;

PLAIT_END_NAMESPACE
