#include "store/guarded_backend.h"

#include <algorithm>
#include <utility>

namespace plait {
namespace {

/// Every entry waits for the disk. A pass that goes from block to block waits once for so much.
constexpr std::uint64_t kMostBytesAhead = 16 << 20;

std::vector<bool> written_blocks(const BlockTable& table) {
  std::vector<bool> written(table.size());
  for (std::uint64_t block = 0; block < table.size(); ++block)
    written[block] = table[block].encoding != BlockEncoding::kNeverWritten;
  return written;
}

}  // namespace

GuardedBackend::GuardedBackend(std::unique_ptr<Backend> inner, const LevelSpec& level,
                               std::uint32_t attribute, int level_number, RollbackJournal& journal)
    : inner_(std::move(inner)),
      geometry_(level.geometry),
      table_(level.table),
      attribute_(attribute),
      level_number_(level_number),
      journal_(journal),
      sequence_(journal.sequence()),
      unkept_(level.mode == OpenMode::kCreate ? std::vector<bool>(level.table.size())
                                              : written_blocks(level.table)) {}

void GuardedBackend::write(BlockRange blocks, std::span<const std::byte> from) {
  keep(blocks);
  inner_->write(blocks, from);
}

void GuardedBackend::start(Transfer& transfer) noexcept {
  if (transfer.direction == Transfer::Direction::kWrite) {
    try {
      keep({transfer.block, 1});
    } catch (...) {
      return transfer.listener->finished(transfer, std::current_exception());
    }
  }
  inner_->start(transfer);
}

std::byte* GuardedBackend::address(std::uint64_t block, bool writable) {
  if (writable) keep({block, 1});
  return inner_->address(block, writable);
}

void GuardedBackend::keep(BlockRange blocks) {
  const std::scoped_lock lock(mutex_);
  // Every write since the last commit came by here: the table is still that of the commit.
  if (sequence_ != journal_.sequence()) {
    sequence_ = journal_.sequence();
    unkept_ = written_blocks(table_);
    ahead_bytes_ = 0;
  }
  const std::uint64_t count = unkept_.size();
  const std::uint64_t end = std::min(count, blocks.first + blocks.count);
  std::vector<std::uint64_t> wanted;
  for (std::uint64_t block = blocks.first; block < end; ++block)
    if (unkept_[block]) wanted.push_back(block);
  if (wanted.empty()) return;

  const std::uint64_t block_bytes = geometry_.max_block_bytes();
  ahead_bytes_ = wanted.front() != next_
                     ? 0
                     : std::min(kMostBytesAhead, std::max(2 * ahead_bytes_, block_bytes));
  std::uint64_t ahead = 0;
  for (std::uint64_t block = end; block < count && unkept_[block]; ++block) {
    ahead += geometry_.block_bytes(block);
    if (ahead > ahead_bytes_) break;
    wanted.push_back(block);
  }
  journal_.keep(attribute_, level_number_, geometry_, wanted);
  for (const std::uint64_t block : wanted) unkept_[block] = false;
  next_ = wanted.back() + 1;
}

}  // namespace plait
