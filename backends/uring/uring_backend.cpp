// A backend whose transfers go through io_uring.
#include <algorithm>
#include <condition_variable>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "blocks/telling_volume.h"
#include "built_in_backends.h"
#include "level_file.h"
#include "plait/detail/level_file.h"
#include "plait/error.h"
#include "uring/page_buffers.h"
#include "uring/pread_instead.h"
#include "uring/uring_ring.h"
#include "uring/uring_runs.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// Waits until a number of transfers have ended.
class Countdown final : public TransferListener {
 public:
  explicit Countdown(std::size_t count) : pending_(count) {}
  void finished(Transfer&, std::exception_ptr error) noexcept override {
    const std::scoped_lock lock(mutex_);
    if (error && !error_) error_ = error;
    if (--pending_ == 0) ended_.notify_all();
  }
  void wait() {
    std::unique_lock lock(mutex_);
    ended_.wait(lock, [&] { return pending_ == 0; });
    if (error_) std::rethrow_exception(error_);
  }

 private:
  std::mutex mutex_;
  std::condition_variable ended_;
  std::size_t pending_;
  std::exception_ptr error_;
};

class UringBackend final : public Backend {
 public:
  /// A page buffer has room for `run_bytes` bytes of a run, or for one block if that is 0.
  UringBackend(const LevelSpec& level, UringRing& ring, PageBuffers& buffers,
               std::uint64_t run_bytes, const std::function<void(const std::string&)>& tell)
      : buffered_run_bytes_(run_bytes),
        level_{level.geometry,
               level.table,
               level.mode,
               level.first_byte,
               ring,
               buffers,
               tell,
               open_fixed_file(level),
               open_direct(level, tell),
               true} {
    level_.goes_past_cache = level_.direct.is_open();
  }

  void read(BlockRange blocks, std::span<std::byte> into) override {
    check_request(level_.geometry, blocks, into.size());
    transfer_all(Transfer::Direction::kRead, blocks, into);
  }

  void write(BlockRange blocks, std::span<const std::byte> from) override {
    check_writable(level_.file, level_.mode);
    check_request(level_.geometry, blocks, from.size());
    // The cast is safe: a write does not change the memory.
    transfer_all(Transfer::Direction::kWrite, blocks,
                 {const_cast<std::byte*>(from.data()), from.size()});
  }

  void start(Transfer& transfer) noexcept override {
    Transfer* const only = &transfer;
    start_run({&only, 1});
  }
  void start_run(std::span<Transfer* const> run) noexcept override;

  void advise(BlockRange, Advice) noexcept override {}
  void sync(bool durable) override {
    if (durable) level_.file.sync();
  }
  std::uint64_t stored_bytes() const override { return fixed_file_bytes(level_.geometry); }

 private:
  /// How many transfers at the beginning of a run can go out in one request.
  std::size_t together(std::span<Transfer* const> run) const noexcept;
  bool reads_as_zeros(const Transfer& transfer) const noexcept {
    return transfer.direction == Transfer::Direction::kRead &&
           level_.table[transfer.block].encoding == BlockEncoding::kNeverWritten;
  }
  /// Whether O_DIRECT can move the block from where it is to where it is to be, whatever comes
  /// before or behind it.
  bool is_in_place(const Transfer& transfer) const noexcept {
    return level_.geometry.block_offset(transfer.block) % kPageBytes == 0 &&
           is_aligned(transfer.memory);
  }

  /// Not open if the file system has no O_DIRECT: then all bytes go through the page cache.
  static File open_direct(const LevelSpec& level,
                          const std::function<void(const std::string&)>& tell) {
    try {
      return {level.directory, level.name,
              level.mode == OpenMode::kRead ? OpenMode::kRead : OpenMode::kReadWrite,
              Caching::kNone};
    } catch (const Error& error) {
      if (error.code() == ErrorCode::kNotSupported) {
        tell_slower(tell, error.what());
        return {};
      }
      if (level.mode == OpenMode::kCreate) level.directory.remove_if_possible(level.name);
      throw;
    }
  }

  void transfer_all(Transfer::Direction direction, BlockRange blocks, std::span<std::byte> memory) {
    constexpr std::uint64_t kAtOnce = 8;
    for (std::uint64_t done = 0; done < blocks.count;) {
      const std::uint64_t count = std::min(kAtOnce, blocks.count - done);
      Countdown all(count);
      std::vector<Transfer> transfers(count);
      for (std::uint64_t i = 0; i < count; ++i) {
        const std::uint64_t block = blocks.first + done + i;
        transfers[i] = {.direction = direction,
                        .block = block,
                        .memory = memory.first(level_.geometry.block_bytes(block)),
                        .listener = &all};
        memory = memory.subspan(transfers[i].memory.size());
      }
      for (Transfer& transfer : transfers) start(transfer);
      all.wait();
      done += count;
    }
  }

  std::uint64_t buffered_run_bytes_;
  UringLevel level_;
};

void UringBackend::start_run(std::span<Transfer* const> run) noexcept {
  while (!run.empty()) {
    Transfer& first = *run.front();
    std::size_t count = 1;
    if (reads_as_zeros(first)) {
      std::ranges::fill(first.memory, std::byte{0});
      first.listener->finished(first, nullptr);
    } else {
      count = together(run);
      start_together(level_, run.first(count), {});
    }
    run = run.subspan(count);
  }
}

std::size_t UringBackend::together(std::span<Transfer* const> run) const noexcept {
  // Neighbours whose memory is not in place need a page buffer for all of them.
  bool in_place = is_in_place(*run.front());
  std::uint64_t bytes = run.front()->memory.size();
  std::size_t count = 1;
  for (; count < run.size() && !reads_as_zeros(*run[count]); ++count) {
    in_place = in_place && is_in_place(*run[count]);
    bytes += run[count]->memory.size();
    if (!in_place && bytes > buffered_run_bytes_) break;
  }
  return count;
}

/// Whether every block of the level begins on a page.
bool blocks_are_aligned(const LevelGeometry& geometry) {
  for (std::uint64_t block = 1; block < geometry.block_count(); ++block)
    if (geometry.block_offset(block) % kPageBytes != 0) return false;
  return true;
}

class UringVolume final : public Volume, public TellingVolume {
 public:
  explicit UringVolume(const VolumeSpec& volume)
      : most_scratch_bytes_(volume.most_scratch_bytes), buffers_(volume.most_scratch_bytes) {}

  std::unique_ptr<Backend> open_level(const LevelSpec& level) override {
    const Needs needs = needs_of(level.geometry);
    auto backend = std::make_unique<UringBackend>(
        level, ring_, buffers_, needs.run_bytes,
        [this](const std::string& line) { keep_first_notice(line); });
    buffers_.make_room_for(needs.buffer_bytes, needs.often);
    return backend;
  }
  std::uint64_t scratch_bytes() const noexcept override { return buffers_.memory_bytes(); }
  std::uint64_t scratch_bytes_with(std::span<const FutureLevel> levels) const override {
    PageBuffers::Room room = buffers_.room();
    std::uint64_t most = buffers_.memory_of(room);
    for (const FutureLevel& level : levels) {
      const Needs needs = needs_of(level.geometry);
      room = buffers_.with(room, needs.buffer_bytes, needs.often);
      most = std::max(most, buffers_.memory_of(room));
    }
    return most;
  }
  std::vector<std::string> notices() const override {
    const std::scoped_lock lock(mutex_);
    return notices_;
  }

 private:
  /// What a level needs of the page buffers.
  struct Needs {
    std::uint64_t buffer_bytes;  ///< of one buffer
    bool often;
    std::uint64_t run_bytes;  ///< of a run that fits into a buffer, or 0
  };
  Needs needs_of(const LevelGeometry& level) const {
    const auto pages = [](std::uint64_t bytes) {
      return (bytes + kPageBytes - 1) / kPageBytes * kPageBytes;
    };
    const std::uint64_t block_bytes = level.max_block_bytes();
    if (blocks_are_aligned(level)) return {pages(block_bytes), false, 0};
    const std::uint64_t run_bytes = block_bytes << most_run_log2(level);
    if (2 * run_bytes > most_scratch_bytes_) return {pages(block_bytes), true, 0};
    return {pages(run_bytes), true, run_bytes};
  }
  /// All levels are on one file system.
  void keep_first_notice(const std::string& line) {
    const std::scoped_lock lock(mutex_);
    if (notices_.empty()) notices_.push_back(line);
  }

  std::uint64_t most_scratch_bytes_;
  PageBuffers buffers_;
  mutable std::mutex mutex_;  ///< guards notices_
  std::vector<std::string> notices_;
  UringRing ring_;
};

}  // namespace

std::unique_ptr<Volume> open_uring_volume(const VolumeSpec& volume) {
  try {
    return std::make_unique<UringVolume>(volume);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kNotSupported) throw;
    return std::make_unique<PreadInstead>(volume, error);
  }
}

void check_uring() { UringRing::check_available(); }

PLAIT_END_NAMESPACE
