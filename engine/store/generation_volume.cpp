#include "store/generation_volume.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <mutex>
#include <optional>
#include <string>
#include <utility>

#include "io/copy_range.h"
#include "plait/error.h"
#include "plait/machine.h"
#include "store/file_names.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr std::uint64_t kVolumePageBytes = 4096;

/// docs/format.md, "Level files".
std::uint64_t level_file_bytes(const LevelGeometry& geometry) {
  return (geometry.total_bytes() + kVolumePageBytes - 1) / kVolumePageBytes * kVolumePageBytes;
}

}  // namespace

class GenerationLevel final : public Backend {
 public:
  GenerationLevel(std::unique_ptr<Backend> inner, const LevelSpec& level, GenerationVolume& volume)
      : level_(level),
        volume_(volume),
        old_(std::move(inner)),
        committed_(level.table.size()),
        renewed_(level.table.size()) {
    level_.held.clear();
    if (level.mode != OpenMode::kCreate) note_committed();
    volume_.levels_.push_back(this);
  }
  ~GenerationLevel() override { std::erase(volume_.levels_, this); }
  GenerationLevel(const GenerationLevel&) = delete;
  GenerationLevel& operator=(const GenerationLevel&) = delete;

  const BlockTable& table() const { return level_.table; }
  bool is_renewed() const { return new_ != nullptr; }

  /// All that was written is of a committed version now; nobody reads or writes meanwhile.
  void begin_version() {
    if (new_) {
      old_ = std::move(new_);
      level_.name = new_name_;
      for (std::atomic<bool>& block : renewed_) block = false;
    }
    note_committed();
  }

  void read(BlockRange blocks, std::span<std::byte> into) override {
    for (std::uint64_t block = blocks.first; block < blocks.first + blocks.count;) {
      Backend& from = home_of(block);
      BlockRange part{block, 1};
      while (part.first + part.count < blocks.first + blocks.count &&
             &home_of(part.first + part.count) == &from)
        ++part.count;
      const std::uint64_t bytes = level_.geometry.range_bytes(part.first, part.count);
      from.read(part, into.first(bytes));
      into = into.subspan(bytes);
      block += part.count;
    }
  }

  void write(BlockRange blocks, std::span<const std::byte> from) override {
    Backend& target = target_of(blocks);
    target.write(blocks, from);
    if (&target != old_.get())
      for (std::uint64_t at = 0; at < blocks.count; ++at) renewed_[blocks.first + at] = true;
  }

  void start(Transfer& transfer) noexcept override;
  std::size_t context(std::uint64_t block,
                      std::span<ContextBlock, kMostContextBlocks> blocks) const noexcept override {
    return (renewed_[block] ? *new_ : *old_).context(block, blocks);
  }
  bool needs_base_records() const noexcept override { return old_->needs_base_records(); }
  void advise(BlockRange blocks, Advice advice) noexcept override {
    home_of(std::min(blocks.first, renewed_.size() - 1)).advise(blocks, advice);
  }
  void sync(bool durable) override {
    if (!new_) return old_->sync(durable);
    copy_the_rest();
    new_->sync(durable);
  }
  std::uint64_t stored_bytes() const override { return old_->stored_bytes(); }

 private:
  class Renewal;

  void note_committed() {
    for (std::uint64_t block = 0; block < committed_.size(); ++block)
      committed_[block] = level_.table[block].encoding != BlockEncoding::kNeverWritten;
  }
  Backend& home_of(std::uint64_t block) { return renewed_[block] ? *new_ : *old_; }
  /// Where these blocks are to be written; makes the new file if that has to be.
  Backend& target_of(BlockRange blocks);
  void copy_the_rest();

  LevelSpec level_;  ///< of the file that the committed version has
  GenerationVolume& volume_;
  std::unique_ptr<Backend> old_, new_;
  std::string new_name_;
  std::mutex making_;                       ///< of new_
  std::vector<bool> committed_;             ///< [block] the committed version has it
  std::vector<std::atomic<bool>> renewed_;  ///< [block] it was written to new_
};

/// Notes that a block was written to the new file, and passes the end of the transfer on.
class GenerationLevel::Renewal final : public TransferListener {
 public:
  Renewal(GenerationLevel& level, TransferListener& listener)
      : level_(level), listener_(listener) {}
  void finished(Transfer& transfer, std::exception_ptr error) noexcept override {
    const std::unique_ptr<Renewal> ends_here(this);
    if (!error) level_.renewed_[transfer.block] = true;
    transfer.listener = &listener_;
    listener_.finished(transfer, std::move(error));
  }

 private:
  GenerationLevel& level_;
  TransferListener& listener_;
};

void GenerationLevel::start(Transfer& transfer) noexcept {
  if (transfer.direction == Transfer::Direction::kRead)
    return home_of(transfer.block).start(transfer);
  TransferListener* const listener = transfer.listener;
  try {
    Backend& target = target_of({transfer.block, 1});
    if (&target != old_.get())
      transfer.listener = std::make_unique<Renewal>(*this, *listener).release();
    target.start(transfer);
  } catch (...) {
    listener->finished(transfer, std::current_exception());
  }
}

Backend& GenerationLevel::target_of(BlockRange blocks) {
  const std::scoped_lock lock(making_);
  if (new_) return *new_;
  const std::uint64_t count = committed_.size();
  const std::uint64_t first = std::min(count, blocks.first);
  const std::uint64_t end = first + std::min(count - first, blocks.count);
  bool overwrites = false;
  for (std::uint64_t block = first; block < end; ++block) overwrites |= committed_[block];
  if (!overwrites) return *old_;

  // By its descriptor: the path may mean another directory by now.
  const std::string store = fmt::format("/proc/self/fd/{}", volume_.store_.descriptor());
  check_free_space(level_, level_file_bytes(level_.geometry), free_disk_bytes(store));
  LevelSpec made = level_;
  made.name =
      level_file_name(level_.table.attribute(), level_.table.level(), volume_.sequence_ + 1);
  made.mode = OpenMode::kCreate;
  volume_.store_.remove(made.name);  // left over by a run that ended before its commit
  new_ = volume_.inner_->open_level(made);
  new_name_ = std::move(made.name);
  return *new_;
}

void GenerationLevel::copy_the_rest() {
  const LevelGeometry& geometry = level_.geometry;
  std::optional<File> from, to;
  for (std::uint64_t block = 0; block < renewed_.size();) {
    const std::uint64_t first = block;
    while (block < renewed_.size() && !renewed_[block] &&
           level_.table[block].encoding != BlockEncoding::kNeverWritten)
      ++block;
    if (block == first) {
      ++block;
      continue;
    }
    if (!from) {
      from.emplace(level_.directory, level_.name, OpenMode::kRead);
      to.emplace(level_.directory, new_name_, OpenMode::kReadWrite);
    }
    copy_range(*from, *to, geometry.block_offset(first),
               geometry.range_bytes(first, block - first));
  }
}

GenerationVolume::GenerationVolume(std::unique_ptr<Volume> inner, const Directory& store,
                                   std::uint64_t sequence)
    : inner_(std::move(inner)), store_(store), sequence_(sequence) {}

GenerationVolume::~GenerationVolume() = default;

std::unique_ptr<Backend> GenerationVolume::open_level(const LevelSpec& level) {
  return std::make_unique<GenerationLevel>(inner_->open_level(level), level, *this);
}

void GenerationVolume::begin_version(std::uint64_t sequence, std::span<const std::uint64_t> held) {
  inner_->begin_version(sequence, held);
  for (GenerationLevel* const level : levels_) level->begin_version();
  sequence_ = sequence;
}

std::vector<GenerationVolume::Level> GenerationVolume::renewed_levels() const {
  std::vector<Level> renewed;
  for (const GenerationLevel* const level : levels_)
    if (level->is_renewed())
      renewed.push_back({level->table().attribute(), level->table().level()});
  return renewed;
}

void check_free_space(const LevelSpec& level, std::uint64_t needed_bytes,
                      std::uint64_t free_bytes) {
  if (needed_bytes <= free_bytes) return;
  throw Error(
      ErrorCode::kNoSpace,
      fmt::format("overwrite {}: the new file of attribute {}, level {} needs {} bytes, and "
                  "the disk has {} free; overwriting in place needs only the journal",
                  level.path().native(), level.table.attribute(), level.table.level(), needed_bytes,
                  free_bytes));
}

PLAIT_END_NAMESPACE
