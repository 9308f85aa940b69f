#include "store/halo_level.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "format/checksum.h"
#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

HaloLevel::HaloLevel(const Directory& directory, std::string name, const LevelFile& frozen,
                     std::span<const EdgeId> edges)
    : directory_(directory),
      name_(std::move(name)),
      frozen_(frozen),
      file_(directory, name_, OpenMode::kCreate) {
  const LevelGeometry& geometry = frozen_.geometry;
  std::uint64_t in_file = 0;
  for (const EdgeId edge : edges) {
    const Slot slot = geometry.slot(edge);
    const std::uint64_t block = geometry.block_of(edge);
    const std::uint64_t in_block = slot.offset - geometry.block_offset(block);
    if (!runs_.empty() && runs_.back().block == block &&
        runs_.back().in_block + runs_.back().bytes == in_block)
      runs_.back().bytes += slot.bytes;
    else
      runs_.push_back(
          {.block = block, .in_block = in_block, .bytes = slot.bytes, .in_file = in_file});
    in_file += slot.bytes;
  }
}

HaloLevel::~HaloLevel() { directory_.remove_if_possible(name_); }

std::span<HaloLevel::Run> HaloLevel::runs_of(std::uint64_t block) {
  const auto first = std::ranges::lower_bound(runs_, block, {}, &Run::block);
  const auto after = std::ranges::upper_bound(runs_, block, {}, &Run::block);
  return {first, after};
}

bool HaloLevel::fills_block(std::span<const Run> runs) const {
  return runs.size() == 1 && runs[0].bytes == frozen_.geometry.block_bytes(runs[0].block);
}

std::vector<bool> HaloLevel::partly_written() const {
  std::vector<bool> partly(frozen_.geometry.block_count(), true);
  for (const Run& run : runs_) partly[run.block] = !fills_block({&run, 1});
  return partly;
}

void HaloLevel::read(BlockRange blocks, std::span<std::byte> into) {
  for (std::uint64_t block = blocks.first; block < blocks.first + blocks.count; ++block) {
    const auto to = into.first(frozen_.geometry.block_bytes(block));
    into = into.subspan(to.size());
    const std::span<const Run> runs = runs_of(block);
    if (!fills_block(runs) || !runs[0].is_written) frozen_.backend->read({block, 1}, to);
    for (const Run& run : runs) {
      if (!run.is_written) continue;
      const auto bytes = to.subspan(run.in_block, run.bytes);
      file_.read_at(run.in_file, bytes);
      if (const std::uint64_t found = checksum_of(bytes); found != run.checksum)
        throw Error(ErrorCode::kCorruption,
                    fmt::format("read {}: offset {}: expected checksum {:016x}, found {:016x}",
                                file_.path().native(), run.in_file, run.checksum, found))
            .about(file_.path());
    }
  }
}

void HaloLevel::write(BlockRange blocks, std::span<const std::byte> from) {
  for (std::uint64_t block = blocks.first; block < blocks.first + blocks.count; ++block) {
    const auto of_block = from.first(frozen_.geometry.block_bytes(block));
    from = from.subspan(of_block.size());
    for (Run& run : runs_of(block)) {
      const auto bytes = of_block.subspan(run.in_block, run.bytes);
      file_.write_at(run.in_file, bytes);
      run.checksum = checksum_of(bytes);
      run.is_written = true;
    }
  }
}

PLAIT_END_NAMESPACE
