#include "store/generation_level.h"

#include <algorithm>
#include <utility>

#include "base/caught.h"
#include "format/file_names.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// Half of the blocks of a smaller level go to the log: a new file costs two syncs.
constexpr std::uint64_t kLeastNewFileBytes = 1u << 20;

}  // namespace

GenerationLevel::GenerationLevel(const LevelSpec& level, GenerationVolume& volume)
    : level_(level), volume_(volume), places_(level.table.size()), committed_(level.table.size()) {
  level_.held.clear();
  file_ = open_file(level.table.generation(), level.mode);
  for (std::uint64_t block = 0; block < places_.size(); ++block) {
    const BlockEntry& entry = level.table[block];
    places_[block] =
        entry.file == kLogFile ? entry.offset | kInLog | volume.current_ : kInLevelFile;
    committed_[block] = level.mode != OpenMode::kCreate && is_stored(block);
  }
  // Readers of a mapped level get addresses in the log, too.
  if (level.mode == OpenMode::kRead && !places_.empty() && file_.backend->address(0) != nullptr)
    volume.logs_[volume.current_]->map();
  file_has_changed_ = level.mode == OpenMode::kCreate;
  volume.most_log_bytes_ += level.geometry.total_bytes() / 2;
  volume.levels_.push_back(this);
}

GenerationLevel::~GenerationLevel() {
  volume_.most_log_bytes_ -= level_.geometry.total_bytes() / 2;
  std::erase(volume_.levels_, this);
}

GenerationLevel::OpenFile GenerationLevel::open_file(std::uint64_t generation,
                                                     OpenMode mode) const {
  LevelSpec spec = level_;
  spec.name = level_file_name(level_.table.attribute(), level_.table.level(), generation);
  spec.mode = mode;
  std::unique_ptr<Backend> backend = volume_.inner_->open_level(spec);
  return {generation, std::move(spec.name), std::move(backend)};
}

bool GenerationLevel::is_stored(std::uint64_t block) const {
  return level_.table[block].encoding != BlockEncoding::kNeverWritten;
}

BlockRange GenerationLevel::run_at(std::uint64_t first, std::uint64_t end) const {
  BlockRange run{first, 1};
  if (is_in_log(places_[first])) return run;
  while (first + run.count < end && places_[first + run.count] == places_[first]) ++run.count;
  return run;
}

void GenerationLevel::read_from_log(std::uint64_t block, std::span<std::byte> into) {
  const BlockPlace place = places_[block];
  ChangeLog& log = volume_.log_at(place);
  log.read(log_offset(place), into);
  level_.table.check(block, into, log.path());
}

void GenerationLevel::read(BlockRange blocks, std::span<std::byte> into) {
  const std::uint64_t end = blocks.first + blocks.count;
  if (end < blocks.first || end > places_.size() ||
      into.size() != level_.geometry.range_bytes(blocks.first, blocks.count))
    return file_.backend->read(blocks, into);  // which refuses it
  for (std::uint64_t block = blocks.first; block < end;) {
    const BlockRange run = run_at(block, end);
    const std::uint64_t bytes = level_.geometry.range_bytes(run.first, run.count);
    if (const BlockPlace place = places_[block]; is_in_log(place))
      read_from_log(block, into.first(bytes));
    else
      backend_of(place).read(run, into.first(bytes));
    into = into.subspan(bytes);
    block += run.count;
  }
}

std::byte* GenerationLevel::address(std::uint64_t block) {
  const BlockPlace place = places_[block];
  return is_in_log(place) ? volume_.log_at(place).address(log_offset(place))
                          : backend_of(place).address(block);
}

void GenerationLevel::advise(BlockRange blocks, Advice advice) noexcept {
  if (advice == Advice::kOverwrite)
    all_will_change_ = true;
  else
    file_.backend->advise(blocks, advice);
}

void GenerationLevel::write_to_log(std::uint64_t block, std::span<const std::byte> from) {
  const BlockPlace before = places_[block];
  const bool again = volume_.is_new(before);
  if (again) volume_.log_at(before).write(log_offset(before), from);
  const BlockPlace place = again ? before : volume_.append(from);
  level_.table.seal(block, log_offset(place), BlockEncoding::kRaw, from);
  level_.table.entries()[block].file = kLogFile;
  places_[block] = place;
  if (again) return;
  const std::scoped_lock lock(making_);
  changed_.push_back(block);
}

void GenerationLevel::write(BlockRange blocks, std::span<const std::byte> from) {
  const std::uint64_t end = blocks.first + blocks.count;
  if (level_.mode == OpenMode::kRead || end < blocks.first || end > places_.size() ||
      from.size() != level_.geometry.range_bytes(blocks.first, blocks.count))
    return file_.backend->write(blocks, from);  // which refuses it
  for (std::uint64_t block = blocks.first; block < end;) {
    const BlockPlace target = target_of(block);
    BlockRange run{block, 1};
    if (!is_in_log(target))
      while (run.first + run.count < end && target_of(run.first + run.count) == target) ++run.count;
    const std::span<const std::byte> bytes =
        from.first(level_.geometry.range_bytes(run.first, run.count));
    if (is_in_log(target)) {
      write_to_log(block, bytes);
    } else {
      backend_of(target).write(run, bytes);
      for (std::uint64_t at = 0; at < run.count; ++at) places_[block + at] = target;
    }
    from = from.subspan(bytes.size());
    block += run.count;
  }
}

/// Notes where a block was written, and passes the end of the transfer on.
class GenerationLevel::Renewal final : public TransferListener {
 public:
  Renewal(GenerationLevel& level, TransferListener& listener)
      : level_(level), listener_(listener) {}
  void finished(Transfer& transfer, std::exception_ptr error) noexcept override {
    const std::unique_ptr<Renewal> ends_here(this);
    if (!error) level_.places_[transfer.block] = kInNewFile;
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

void GenerationLevel::move_in_log(Transfer& transfer) noexcept {
  std::exception_ptr error;
  try {
    if (transfer.direction == Transfer::Direction::kRead)
      read_from_log(transfer.block, transfer.memory);
    else
      write_to_log(transfer.block, transfer.memory);
  } catch (...) {
    error = caught_exception();
  }
  transfer.listener->finished(transfer, std::move(error));
}

void GenerationLevel::start_run(std::span<Transfer* const> run) noexcept {
  // Those at the beginning of the run that go to one file begin before the next is looked at.
  Backend* file = nullptr;
  std::size_t first = 0;
  for (std::size_t at = 0; at < run.size(); ++at) {
    Transfer& transfer = *run[at];
    Backend* next = nullptr;
    std::exception_ptr error;
    try {
      next = file_of(transfer);
    } catch (...) {
      error = caught_exception();
    }
    if (file && next != file) start_in(*file, run.subspan(first, at - first));
    if (next != file) first = at;
    file = next;
    if (file) continue;
    if (error)
      transfer.listener->finished(transfer, error);
    else
      move_in_log(transfer);
  }
  if (file) start_in(*file, run.subspan(first));
}

Backend* GenerationLevel::file_of(Transfer& transfer) {
  const bool reads = transfer.direction == Transfer::Direction::kRead;
  const BlockPlace place = reads ? places_[transfer.block].load() : target_of(transfer.block);
  if (is_in_log(place)) return nullptr;
  if (!reads && place == kInNewFile)
    transfer.listener = std::make_unique<Renewal>(*this, *transfer.listener).release();
  return &backend_of(place);
}

BlockPlace GenerationLevel::target_of(std::uint64_t block) {
  const std::scoped_lock lock(making_);
  if (new_.backend) return kInNewFile;
  if (level_.mode == OpenMode::kRead) return kInLevelFile;  // which refuses it
  if (!committed_[block]) {
    file_has_changed_ = true;
    return kInLevelFile;
  }
  const std::uint64_t changed = changed_.size() + 1;
  const bool is_half = 2 * changed >= places_.size() &&
                       changed * level_.geometry.max_block_bytes() >= kLeastNewFileBytes;
  if (!all_will_change_ && !is_half) return kInLog;
  make_new_file();
  return kInNewFile;
}

void GenerationLevel::make_new_file() {
  const std::uint64_t generation = volume_.sequence_ + 1;
  // A run that ended before its commit may have left such a file.
  volume_.store_.remove(
      level_file_name(level_.table.attribute(), level_.table.level(), generation));
  new_ = open_file(generation, OpenMode::kCreate);
}

bool GenerationLevel::uses_log() const { return count_in_log() > 0; }

std::uint64_t GenerationLevel::count_in_log() const {
  return static_cast<std::uint64_t>(std::ranges::count_if(
      places_, [](const std::atomic<BlockPlace>& place) { return is_in_log(place); }));
}

std::uint64_t GenerationLevel::stored_bytes() const {
  return file_.backend->stored_bytes() + count_in_log() * level_.geometry.max_block_bytes();
}

PLAIT_END_NAMESPACE
