#include "store/journaled_volume.h"

#include <algorithm>
#include <mutex>
#include <string>
#include <utility>

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// Every entry waits for the disk. A pass that goes from block to block waits once for so much.
constexpr std::uint64_t kMostBytesAhead = 16 << 20;

bool is_written(const BlockTable& table, std::uint64_t block) {
  return table[block].encoding != BlockEncoding::kNeverWritten;
}

}  // namespace

class JournaledLevel final : public Backend {
 public:
  JournaledLevel(std::unique_ptr<Backend> inner, const LevelSpec& level, JournaledVolume& volume)
      : inner_(std::move(inner)),
        name_(level.name),
        geometry_(level.geometry),
        table_(level.table),
        volume_(volume),
        unkept_(level.table.size()) {
    if (level.mode != OpenMode::kCreate) begin_version();
    volume_.levels_.push_back(this);
  }
  ~JournaledLevel() override { std::erase(volume_.levels_, this); }
  JournaledLevel(const JournaledLevel&) = delete;
  JournaledLevel& operator=(const JournaledLevel&) = delete;

  /// All that was written is of a committed version now.
  void begin_version() {
    const std::scoped_lock lock(mutex_);
    for (std::uint64_t block = 0; block < unkept_.size(); ++block)
      unkept_[block] = is_written(table_, block);
    ahead_bytes_ = 0;
  }

  void read(BlockRange blocks, std::span<std::byte> into) override { inner_->read(blocks, into); }
  void write(BlockRange blocks, std::span<const std::byte> from) override {
    keep(blocks);
    inner_->write(blocks, from);
  }
  void start(Transfer& transfer) noexcept override {
    if (transfer.direction == Transfer::Direction::kWrite) {
      try {
        keep({transfer.block, 1});
      } catch (...) {
        return transfer.listener->finished(transfer, std::current_exception());
      }
    }
    inner_->start(transfer);
  }
  std::byte* address(std::uint64_t block) override { return inner_->address(block); }
  std::size_t context(std::uint64_t block,
                      std::span<ContextBlock, kMostContextBlocks> blocks) const noexcept override {
    return inner_->context(block, blocks);
  }
  bool needs_base_records() const noexcept override { return inner_->needs_base_records(); }
  void advise(BlockRange blocks, Advice advice) noexcept override {
    inner_->advise(blocks, advice);
  }
  void sync(bool durable) override { inner_->sync(durable); }
  std::uint64_t stored_bytes() const override { return inner_->stored_bytes(); }

 private:
  void keep(BlockRange blocks);

  std::unique_ptr<Backend> inner_;
  std::string name_;
  const LevelGeometry& geometry_;
  const BlockTable& table_;
  JournaledVolume& volume_;

  std::mutex mutex_;
  std::vector<bool> unkept_;       ///< [block] is of the committed version, not in the journal
  std::uint64_t next_ = 0;         ///< the block after those entered last
  std::uint64_t ahead_bytes_ = 0;  ///< entered beside what was asked for
};

void JournaledLevel::keep(BlockRange blocks) {
  const std::scoped_lock lock(mutex_);
  const std::uint64_t count = unkept_.size();
  const std::uint64_t first = std::min(count, blocks.first);
  const std::uint64_t end = first + std::min(count - first, blocks.count);
  std::vector<std::uint64_t> wanted;
  for (std::uint64_t block = first; block < end; ++block)
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
  volume_.journal_.keep(name_, table_, geometry_, wanted);
  for (const std::uint64_t block : wanted) unkept_[block] = false;
  next_ = wanted.back() + 1;
}

JournaledVolume::JournaledVolume(std::unique_ptr<Volume> inner, RollbackJournal& journal)
    : inner_(std::move(inner)), journal_(journal) {}

JournaledVolume::~JournaledVolume() = default;

std::unique_ptr<Backend> JournaledVolume::open_level(const LevelSpec& level) {
  return std::make_unique<JournaledLevel>(inner_->open_level(level), level, *this);
}

void JournaledVolume::begin_version(std::uint64_t sequence, std::span<const std::uint64_t> held) {
  inner_->begin_version(sequence, held);
  for (JournaledLevel* const level : levels_) level->begin_version();
  journal_.begin_version(sequence);
}

PLAIT_END_NAMESPACE
