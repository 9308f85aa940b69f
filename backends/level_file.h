// backends/level_file.h: what the backends share: opening a level's file, checking a request, and
// sealing and verifying raw blocks that lie where the geometry puts them ("fixed-offset" levels).
//
// A fixed-offset level file is the level's raw bytes, padded with zeros to a multiple of
// kPageBytes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "plait/backend.h"

namespace plait {

constexpr std::uint64_t kPageBytes = 4096;

/// Size of the file of a fixed-offset level.
std::uint64_t fixed_file_bytes(const LevelGeometry& geometry);

/// Creates the level's file at its full size, its space taken from the disk, or opens it and checks
/// its size and that every entry of the table is one that a fixed-offset backend writes. A file
/// that cannot be made whole is removed again. Errors: kCorruption, kIo, kNoSpace, kInvalidArgument
/// as check_level.
File open_fixed_file(const LevelSpec& level);

/// Refuses a table of another size than the level, and blocks beyond `max_block_bytes`.
/// Errors: kInvalidArgument.
void check_level(const LevelSpec& level, std::uint64_t max_block_bytes);

/// Refuses blocks that the level does not have, and a span of another size than theirs.
/// Errors: kInvalidArgument.
void check_request(const LevelGeometry& geometry, BlockRange blocks, std::size_t span_bytes);

/// Errors: kBadState for a level that was opened for reading.
void check_writable(const File& file, OpenMode mode);

/// The part of `blocks` that the level has, in bytes of a fixed-offset level: for advice, which
/// never fails.
struct ByteRange {
  std::uint64_t first = 0, count = 0;
};
ByteRange fixed_bytes(const LevelGeometry& geometry, BlockRange blocks) noexcept;

/// Seals the raw bytes `from` of these blocks at the geometry's offsets.
void seal_raw(const LevelGeometry& geometry, BlockTable& table, BlockRange blocks,
              std::span<const std::byte> from);

/// Verifies the raw bytes `into` of these blocks; those never written become zeros.
/// Errors: kCorruption naming `path`.
void check_raw(const LevelGeometry& geometry, const BlockTable& table, BlockRange blocks,
               std::span<std::byte> into, const std::filesystem::path& path);

/// Makes those of these blocks zeros that were never written.
void zero_unwritten(const LevelGeometry& geometry, const BlockTable& table, BlockRange blocks,
                    std::span<std::byte> into);

/// For backends that hand out addresses: the bytes may be where they belong already.
void copy_unless_same(const std::byte* from, std::byte* to, std::size_t bytes);

/// Lets the system begin to write to the disk what it was given, and does not wait:
/// sync_file_range, which msync(MS_ASYNC) is not on Linux. Where it is not supported sync() does
/// all of it. Errors: kIo naming the file.
void start_writing(const File& file, ByteRange bytes);

/// posix_fadvise. Sequential and random are properties of the whole descriptor on Linux.
void advise_file(const File& file, ByteRange bytes, Advice advice) noexcept;

}  // namespace plait
