#include "compressed/extent_allocator.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <utility>

#include "plait/error.h"

namespace plait {
namespace {

constexpr std::uint64_t aligned(std::uint64_t bytes) {
  constexpr std::uint64_t kAlignment = ExtentAllocator::kAlignmentBytes;
  return (bytes + kAlignment - 1) / kAlignment * kAlignment;
}

}  // namespace

ExtentAllocator::ExtentAllocator(std::span<const BlockEntry> table, std::uint64_t file_bytes,
                                 const std::filesystem::path& file)
    : held_(table.size()) {
  std::vector<std::uint64_t> blocks;
  for (std::uint64_t block = 0; block < table.size(); ++block) {
    const BlockEntry& entry = table[block];
    if (entry.encoding == BlockEncoding::kNeverWritten) continue;
    if (entry.offset % kAlignmentBytes != 0 || entry.stored_bytes == 0 ||
        entry.offset > file_bytes || entry.stored_bytes > file_bytes - entry.offset)
      throw Error(ErrorCode::kCorruption,
                  fmt::format("open {}: block {}: expected an extent at a multiple of {} within {} "
                              "bytes, found {} bytes at byte {}",
                              file.native(), block, kAlignmentBytes, file_bytes, entry.stored_bytes,
                              entry.offset));
    held_[block] = true;
    blocks.push_back(block);
  }
  std::ranges::sort(blocks, {}, [&](std::uint64_t block) { return table[block].offset; });
  for (const std::uint64_t block : blocks) {
    const BlockEntry& entry = table[block];
    if (entry.offset < end_bytes_)
      throw Error(
          ErrorCode::kCorruption,
          fmt::format(
              "open {}: block {}: expected an extent apart from all others, found one at byte "
              "{} inside one that ends at {}",
              file.native(), block, entry.offset, end_bytes_));
    if (entry.offset > end_bytes_) insert_free(end_bytes_, entry.offset - end_bytes_);
    end_bytes_ = entry.offset + aligned(entry.stored_bytes);
  }
}

std::uint64_t ExtentAllocator::allocate(std::uint64_t bytes) {
  bytes = aligned(bytes);
  const auto fitting = free_by_bytes_.lower_bound({bytes, 0});
  if (fitting == free_by_bytes_.end()) {
    const std::uint64_t offset = end_bytes_;
    end_bytes_ += bytes;
    return offset;
  }
  const auto [found_bytes, offset] = *fitting;
  erase_free(free_.find(offset));
  if (found_bytes > bytes) insert_free(offset + bytes, found_bytes - bytes);
  return offset;
}

void ExtentAllocator::release(std::uint64_t offset, std::uint64_t bytes) {
  bytes = aligned(bytes);
  const auto after = free_.lower_bound(offset);
  if (after != free_.begin()) {
    const auto before = std::prev(after);
    if (before->first + before->second == offset) {
      offset = before->first;
      bytes += before->second;
      erase_free(before);
    }
  }
  if (after != free_.end() && after->first == offset + bytes) {
    bytes += after->second;
    erase_free(after);
  }
  if (offset + bytes == end_bytes_)
    end_bytes_ = offset;
  else
    insert_free(offset, bytes);
}

void ExtentAllocator::replace(std::uint64_t block, const BlockEntry& former) {
  if (former.encoding == BlockEncoding::kNeverWritten) return;
  if (!held_[block]) return release(former.offset, former.stored_bytes);
  held_[block] = false;
  replaced_.emplace_back(former.offset, former.stored_bytes);
}

void ExtentAllocator::hold(std::span<const BlockEntry> table) {
  for (const auto& [offset, bytes] : replaced_before_) release(offset, bytes);
  replaced_before_ = std::exchange(replaced_, {});
  for (std::uint64_t block = 0; block < table.size(); ++block)
    held_[block] = table[block].encoding != BlockEncoding::kNeverWritten;
}

void ExtentAllocator::insert_free(std::uint64_t offset, std::uint64_t bytes) {
  free_.emplace(offset, bytes);
  free_by_bytes_.emplace(bytes, offset);
}

void ExtentAllocator::erase_free(std::map<std::uint64_t, std::uint64_t>::iterator extent) {
  free_by_bytes_.erase({extent->second, extent->first});
  free_.erase(extent);
}

}  // namespace plait
