#include "store/generation_level.h"

#include <algorithm>
#include <utility>

#include "base/caught.h"
#include "format/file_names.h"
#include "plait/extend/file.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

GenerationLevel::GenerationLevel(const LevelSpec& level, GenerationVolume& volume)
    : level_(level), volume_(volume), committed_(level.table.size()), home_(level.table.size()) {
  level_.held.clear();
  for (const Generation& generation : level.table.generations())
    files_.push_back(open_file(generation, files_.empty() ? level.mode : OpenMode::kRead));
  for (std::uint64_t block = 0; block < home_.size(); ++block)
    home_[block] = static_cast<Home>(level.table[block].file);
  if (level.mode != OpenMode::kCreate) note_committed();
  volume_.levels_.push_back(this);
}

GenerationLevel::~GenerationLevel() { std::erase(volume_.levels_, this); }

GenerationLevel::OpenFile GenerationLevel::open_file(const Generation& generation,
                                                     OpenMode mode) const {
  LevelSpec spec = level_;
  spec.name = level_file_name(level_.table.attribute(), level_.table.level(), generation.version);
  spec.mode = mode;
  spec.is_sparse = generation.blocks > 0;
  std::unique_ptr<Backend> backend = volume_.inner_->open_level(spec);
  return {generation, std::move(spec.name), std::move(backend)};
}

bool GenerationLevel::is_stored(std::uint64_t block) const {
  return level_.table[block].encoding != BlockEncoding::kNeverWritten;
}

void GenerationLevel::note_committed() {
  for (std::uint64_t block = 0; block < committed_.size(); ++block)
    committed_[block] = is_stored(block);
}

BlockRange GenerationLevel::run_at(std::uint64_t first, std::uint64_t end) const {
  BlockRange run{first, 1};
  while (first + run.count < end && home_[first + run.count] == home_[first]) ++run.count;
  return run;
}

void GenerationLevel::read(BlockRange blocks, std::span<std::byte> into) {
  const std::uint64_t end = blocks.first + blocks.count;
  if (end < blocks.first || end > home_.size()) return files_.front().backend->read(blocks, into);
  for (std::uint64_t block = blocks.first; block < end;) {
    const BlockRange run = run_at(block, end);
    const std::uint64_t bytes = level_.geometry.range_bytes(run.first, run.count);
    home_of(block).read(run, into.first(bytes));
    into = into.subspan(bytes);
    block += run.count;
  }
}

void GenerationLevel::advise(BlockRange blocks, Advice advice) noexcept {
  if (advice == Advice::kOverwrite) {
    all_will_change_ = true;
    return;
  }
  if (advice == Advice::kSequential) {
    for (const OpenFile& file : files_) file.backend->advise(blocks, advice);
    return;
  }
  const std::uint64_t first = std::min<std::uint64_t>(blocks.first, home_.size());
  const std::uint64_t end = first + std::min(blocks.count, home_.size() - first);
  for (std::uint64_t block = first; block < end;) {
    const BlockRange run = run_at(block, end);
    home_of(block).advise(run, advice);
    block += run.count;
  }
}

void GenerationLevel::write(BlockRange blocks, std::span<const std::byte> from) {
  OpenFile& target = target_of(blocks);
  target.backend->write(blocks, from);
  const Home home = &target == &new_ ? new_home() : Home{0};
  for (std::uint64_t at = 0; at < blocks.count; ++at) note_written(blocks.first + at, home);
}

/// Notes where a block was written, and passes the end of the transfer on.
class GenerationLevel::Renewal final : public TransferListener {
 public:
  Renewal(GenerationLevel& level, TransferListener& listener)
      : level_(level), listener_(listener) {}
  void finished(Transfer& transfer, std::exception_ptr error) noexcept override {
    const std::unique_ptr<Renewal> ends_here(this);
    if (!error) level_.note_written(transfer.block, level_.new_home());
    transfer.listener = &listener_;
    listener_.finished(transfer, std::move(error));
  }

 private:
  GenerationLevel& level_;
  TransferListener& listener_;
};

void GenerationLevel::start_in(Backend& backend, std::span<Transfer* const> run) noexcept {
  if (run.empty()) return;
  run.size() == 1 ? backend.start(*run.front()) : backend.start_run(run);
}

void GenerationLevel::start_run(std::span<Transfer* const> run) noexcept {
  // Those at the beginning of the run that go to one file begin before the next is looked at.
  Backend* file = nullptr;
  std::size_t first = 0;
  for (std::size_t at = 0; at < run.size(); ++at) {
    Transfer& transfer = *run[at];
    Backend* next = nullptr;
    try {
      next = file_of(transfer);
    } catch (...) {
      if (file) start_in(*file, run.subspan(first, at - first));
      first = at + 1;
      file = nullptr;
      transfer.listener->finished(transfer, caught_exception());
      continue;
    }
    if (file && next != file) {
      start_in(*file, run.subspan(first, at - first));
      first = at;
    }
    file = next;
  }
  if (file) start_in(*file, run.subspan(first));
}

Backend* GenerationLevel::file_of(Transfer& transfer) {
  if (transfer.direction == Transfer::Direction::kRead) return &home_of(transfer.block);
  OpenFile& target = target_of({transfer.block, 1});
  if (&target == &new_)
    transfer.listener = std::make_unique<Renewal>(*this, *transfer.listener).release();
  return target.backend.get();
}

void GenerationLevel::note_written(std::uint64_t block, Home home) {
  if (home_[block].exchange(home) != home && home != 0) ++new_blocks_;
}

GenerationLevel::OpenFile& GenerationLevel::target_of(BlockRange blocks) {
  const std::scoped_lock lock(making_);
  if (!new_.backend) {
    const std::uint64_t count = committed_.size();
    const std::uint64_t first = std::min(count, blocks.first);
    const std::uint64_t end = first + std::min(count - first, blocks.count);
    bool overwrites = false;
    for (std::uint64_t block = first; block < end; ++block) overwrites |= committed_[block];
    if (!overwrites || level_.mode == OpenMode::kRead) return files_.front();
    has_room_ = all_will_change_;
    const Generation next{volume_.sequence_ + 1, has_room_ ? std::uint64_t{0} : 1};
    // A run that ended before its commit may have left such a file.
    volume_.store_.remove(
        level_file_name(level_.table.attribute(), level_.table.level(), next.version));
    new_ = open_file(next, OpenMode::kCreate);
  }
  // So many blocks make the new file the level, so it takes the space of the others now.
  if (!has_room_ && holds_half(new_blocks_)) {
    File file(level_.directory, new_.name, OpenMode::kReadWrite);
    file.preallocate(file.size());
    has_room_ = true;
  }
  return new_;
}

std::uint64_t GenerationLevel::sparse_blocks() const {
  std::uint64_t blocks = new_blocks_;
  for (const OpenFile& file : files_) blocks += file.generation.blocks;
  return blocks;
}

std::uint64_t GenerationLevel::stored_bytes() const {
  return files_.front().backend->stored_bytes() +
         sparse_blocks() * level_.geometry.max_block_bytes();
}

PLAIT_END_NAMESPACE
