#include "compressed/extent_allocator.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <tuple>
#include <utility>

#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr std::uint64_t aligned(std::uint64_t bytes) {
  constexpr std::uint64_t kAlignment = ExtentAllocator::kAlignmentBytes;
  return (bytes + kAlignment - 1) / kAlignment * kAlignment;
}

bool has_extent(const BlockEntry& entry) {
  return entry.encoding != BlockEncoding::kNeverWritten &&
         entry.encoding != BlockEncoding::kPredicted;
}

bool is_same(const BlockEntry& a, const BlockEntry& b) {
  return a.offset == b.offset && a.stored_bytes == b.stored_bytes;
}

}  // namespace

ExtentAllocator::ExtentAllocator(std::span<const BlockEntry> table, std::uint64_t file_bytes,
                                 const std::filesystem::path& file, std::span<const HeldTable> held)
    : first_version_(table.size(), kNoVersion) {
  struct Extent {
    BlockEntry entry;
    std::uint64_t block, version;  ///< the newest is kNoVersion
  };
  std::vector<Extent> extents;
  const auto add = [&](std::span<const BlockEntry> entries, std::uint64_t version) {
    for (std::uint64_t block = 0; block < entries.size(); ++block) {
      const BlockEntry& entry = entries[block];
      if (!has_extent(entry)) continue;
      if (entry.offset % kAlignmentBytes != 0 || entry.stored_bytes == 0 ||
          entry.offset > file_bytes || entry.stored_bytes > file_bytes - entry.offset)
        throw Error(ErrorCode::kCorruption,
                    fmt::format("open {}: block {}: expected an extent at a multiple of {} within "
                                "{} bytes, found {} bytes at byte {}",
                                file.native(), block, kAlignmentBytes, file_bytes,
                                entry.stored_bytes, entry.offset));
      extents.push_back({entry, block, version});
    }
  };
  add(table, kNoVersion);
  std::uint64_t next_to_be_held = 0;
  for (const HeldTable& older : held) {
    add(older.table->entries(), older.version);
    next_to_be_held = std::max(next_to_be_held, older.version + 1);
  }
  std::ranges::sort(extents, {}, [](const Extent& extent) {
    return std::tuple(extent.entry.offset, extent.version);
  });
  for (std::size_t at = 0; at < extents.size();) {
    const auto& [entry, block, version] = extents[at];
    if (entry.offset < end_bytes_)
      throw Error(ErrorCode::kCorruption,
                  fmt::format("open {}: block {}: expected an extent of its own, found one at byte "
                              "{} in another that ends at {}",
                              file.native(), block, entry.offset, end_bytes_));
    // The versions that have this extent are consecutive, in ascending order.
    std::size_t last = at;
    while (last + 1 < extents.size() && extents[last + 1].version != extents[last].version &&
           extents[last + 1].block == block && is_same(extents[last + 1].entry, entry))
      ++last;
    if (extents[last].version == kNoVersion)
      // Readers that are there at the moment have nothing of this extent, unless a table says so.
      first_version_[block] = at == last ? next_to_be_held : version;
    else
      retired_.push_back({entry.offset, entry.stored_bytes, version, extents[last].version});
    if (entry.offset > end_bytes_) insert_free(end_bytes_, entry.offset - end_bytes_);
    end_bytes_ = entry.offset + aligned(entry.stored_bytes);
    at = last + 1;
  }
}

std::uint64_t ExtentAllocator::add_blocks(std::uint64_t count) {
  const std::uint64_t first = first_version_.size();
  first_version_.resize(first + count, kNoVersion);
  return first;
}

std::uint64_t ExtentAllocator::bytes_of(std::span<const BlockEntry> table) {
  std::uint64_t bytes = 0;
  for (const BlockEntry& entry : table)
    if (has_extent(entry)) bytes += aligned(entry.stored_bytes);
  return bytes;
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
  const std::uint64_t first = std::exchange(first_version_[block], kNoVersion);
  if (!has_extent(former)) return;
  if (first == kNoVersion) return release(former.offset, former.stored_bytes);
  retired_.push_back({former.offset, former.stored_bytes, first, kNoVersion});
}

void ExtentAllocator::begin_version(std::uint64_t sequence, std::span<const std::uint64_t> held) {
  const auto is_held = [&](const Retired& extent) {
    const auto from = std::ranges::lower_bound(held, extent.first);
    return from != held.end() && *from <= extent.last;
  };
  std::erase_if(retired_, [&](Retired& extent) {
    if (extent.last == kNoVersion) extent.last = sequence - 1;
    if (extent.last + 1 >= sequence || is_held(extent)) return false;
    release(extent.offset, extent.bytes);
    return true;
  });
  for (std::uint64_t& first : first_version_) first = std::min(first, sequence);
}

void ExtentAllocator::insert_free(std::uint64_t offset, std::uint64_t bytes) {
  free_.emplace(offset, bytes);
  free_by_bytes_.emplace(bytes, offset);
}

void ExtentAllocator::erase_free(std::map<std::uint64_t, std::uint64_t>::iterator extent) {
  free_by_bytes_.erase({extent->second, extent->first});
  free_.erase(extent);
}

PLAIT_END_NAMESPACE
