#include "maintenance/read_block.h"

#include <algorithm>
#include <array>
#include <condition_variable>
#include <future>
#include <mutex>
#include <new>
#include <utility>
#include <vector>

#include "paging/frame_pool.h"
#include "plait/extend/pager.h"
#include "plait/extend/store_access.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// The runs that a pass over a level has in memory: one is pinned, one was before, the others are
/// read ahead.
constexpr std::uint64_t kSourceRuns = Pager::kInFlight + 2;

/// The bytes of frames for the blocks that move together.
std::uint64_t bytes_of_run(const LevelFile& level) {
  return FramePool::frame_bytes(level.geometry.max_block_bytes()) << level.run_log2;
}

class Waiting final : public TransferListener {
 public:
  void finished(Transfer&, std::exception_ptr error) noexcept override {
    if (error)
      done_.set_exception(std::move(error));
    else
      done_.set_value();
  }
  void wait() { done_.get_future().get(); }

 private:
  std::promise<void> done_;
};

/// Waits until each transfer of a run has ended, and keeps how: errors[tag].
class WaitingForAll final : public TransferListener {
 public:
  explicit WaitingForAll(std::vector<std::exception_ptr>& errors)
      : errors_(errors), pending_(errors.size()) {}
  void finished(Transfer& transfer, std::exception_ptr error) noexcept override {
    const std::scoped_lock lock(mutex_);
    errors_[transfer.tag] = std::move(error);
    if (--pending_ == 0) ended_.notify_all();
  }
  void wait() {
    std::unique_lock lock(mutex_);
    ended_.wait(lock, [&] { return pending_ == 0; });
  }

 private:
  std::vector<std::exception_ptr>& errors_;
  std::size_t pending_;
  std::mutex mutex_;
  std::condition_variable ended_;
};

constexpr std::size_t kAlignment = 4096;  // of frames

/// Finds the attribute whose block tables have this number.
AttributeId numbered(const Store& store, const ContextBlock& needed) {
  for (AttributeId id = 0; id < store.attributes().size(); ++id)
    if (store.attributes()[id].finest_level >= needed.level &&
        StoreAccess::level_file(store, id, needed.level).table.attribute() == needed.attribute)
      return id;
  return kNoId;
}

}  // namespace

PinnedContext::PinnedContext(const Store& store, std::span<const ContextBlock> needed)
    : session_(StoreAccess::open_session(store)), pinned_(needed.size()) {
  std::vector<BlockRequest> requests;
  for (const ContextBlock& block : needed)
    requests.emplace_back(StoreAccess::level_file(store, block.attribute, block.level),
                          block.block);
  session_.pin_many(requests, pinned_);
  for (const PinnedBlock& block : pinned_) bytes_.push_back(block.bytes());
}

void read_block(const Store& store, AttributeId attribute, int level, std::uint64_t block,
                std::span<std::byte> into) {
  Backend& backend = *StoreAccess::level_file(store, attribute, level).backend;
  std::array<ContextBlock, kMostContextBlocks> needed;
  const std::size_t count = backend.read_context(block, needed);
  if (count == 0) return backend.read({block, 1}, into);

  for (ContextBlock& other : std::span(needed).first(count))
    other.attribute = numbered(store, other);
  const PinnedContext context(store, std::span(needed).first(count));
  Waiting waiting;
  Transfer transfer;
  transfer.block = block;
  transfer.memory = into;
  transfer.context = context.bytes();
  transfer.listener = &waiting;
  backend.start(transfer);
  waiting.wait();
}

void RunBuffer::Free::operator()(std::byte* memory) const {
  ::operator delete(memory, std::align_val_t(kAlignment));
}

void RunBuffer::read(const Store& store, AttributeId attribute, int level, std::uint64_t block) {
  const LevelFile& file = StoreAccess::level_file(store, attribute, level);
  if (file_ != &file || block < blocks_.first || block >= blocks_.first + blocks_.count) {
    const BlockRange run = run_of(file, block);
    file_ = nullptr;
    blocks_ = {block, 1};
    while (block + blocks_.count < run.first + run.count &&
           file.table[block + blocks_.count].encoding != BlockEncoding::kNeverWritten)
      ++blocks_.count;
    const std::uint64_t bytes =
        blocks_.count * FramePool::frame_bytes(file.geometry.max_block_bytes());
    if (bytes > bytes_) {
      memory_.reset();
      bytes_ = 0;
      memory_.reset(static_cast<std::byte*>(::operator new(bytes, std::align_val_t(kAlignment))));
      bytes_ = bytes;
    }
    errors_.assign(blocks_.count, nullptr);
    if (blocks_.count > 1)
      read_run(file);
    else
      read_block(store, attribute, level, block, {memory_.get(), file.geometry.block_bytes(block)});
    file_ = &file;
  }
  if (const std::exception_ptr& error = errors_[block - blocks_.first])
    std::rethrow_exception(error);
}

void RunBuffer::read_run(const LevelFile& file) {
  const std::uint64_t frame_bytes = FramePool::frame_bytes(file.geometry.max_block_bytes());
  WaitingForAll waiting(errors_);
  std::vector<Transfer> transfers(blocks_.count);
  std::vector<Transfer*> run;
  for (std::uint64_t i = 0; i < blocks_.count; ++i) {
    const std::uint64_t block = blocks_.first + i;
    transfers[i] = {.block = block,
                    .memory = {memory_.get() + i * frame_bytes, file.geometry.block_bytes(block)},
                    .listener = &waiting,
                    .tag = static_cast<std::uint32_t>(i)};
    run.push_back(&transfers[i]);
  }
  file.backend->start_run(run);
  waiting.wait();
}

Session open_source_session(const Store& store, const LevelFile& level) {
  if (needs_other_blocks(level)) return StoreAccess::open_session(store);
  const std::uint64_t half = StoreAccess::pager(store).budget_bytes() / 2;
  return StoreAccess::open_session(
      store, {.share_bytes = std::min(kSourceRuns * bytes_of_run(level), half)});
}

std::uint64_t spare_source_bytes(const Store& store) {
  std::uint64_t ahead = 0, others = 0;
  for (AttributeId id = 0; id < store.attributes().size(); ++id) {
    std::uint64_t of_levels = 0;
    for (int level = store.base_level() + 1; level <= store.attributes()[id].finest_level;
         ++level) {
      const LevelFile& file = StoreAccess::level_file(store, id, level);
      if (needs_other_blocks(file)) return 0;
      ahead = std::max(ahead, kSourceRuns * bytes_of_run(file));
      of_levels += bytes_of_run(file);
    }
    others = std::max(others, of_levels);
  }
  const std::uint64_t frames = StoreAccess::pager(store).budget_bytes();
  return frames - std::min(ahead + others, frames);
}

PLAIT_END_NAMESPACE
