// The bytes of a block in the file:
//
//   | head | whole pages ...                            | tail |
//
// Head and tail are parts of pages that the block shares with its neighbours. Both are empty if all
// blocks of the level begin and end at page boundaries. Whole pages go past the page cache. Shared
// pages always go through the page cache: there the kernel combines the parts, even if several
// threads write them at the same time. No byte is ever accessed both ways.
#include <algorithm>
#include <atomic>
#include <cerrno>
#include <condition_variable>
#include <cstring>
#include <functional>
#include <mutex>
#include <string>
#include <vector>

#include "base/caught.h"
#include "blocks/telling_volume.h"
#include "built_in_backends.h"
#include "io/file_operations.h"
#include "io/system_call.h"
#include "level_file.h"
#include "plait/error.h"
#include "uring/page_buffers.h"
#include "uring/pread_instead.h"
#include "uring/uring_ring.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

bool is_aligned(const std::byte* memory) {
  return reinterpret_cast<std::uintptr_t>(memory) % kPageBytes == 0;
}

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
  UringBackend(const LevelSpec& level, UringRing& ring, PageBuffers& buffers,
               const std::function<void(const std::string&)>& tell)
      : geometry_(level.geometry),
        table_(level.table),
        mode_(level.mode),
        ring_(ring),
        buffers_(buffers),
        tell_(tell),
        file_(open_fixed_file(level)),
        direct_(open_direct(level, tell)),
        goes_past_cache_(direct_.is_open()) {}

  void read(BlockRange blocks, std::span<std::byte> into) override {
    check_request(geometry_, blocks, into.size());
    transfer_all(Transfer::Direction::kRead, blocks, into);
  }

  void write(BlockRange blocks, std::span<const std::byte> from) override {
    check_writable(file_, mode_);
    check_request(geometry_, blocks, from.size());
    // The cast is safe: a write does not change the memory.
    transfer_all(Transfer::Direction::kWrite, blocks,
                 {const_cast<std::byte*>(from.data()), from.size()});
  }

  void start(Transfer& transfer) noexcept override;

  void advise(BlockRange, Advice) noexcept override {}
  void sync(bool durable) override {
    if (durable) file_.sync();
  }
  std::uint64_t stored_bytes() const override { return fixed_file_bytes(geometry_); }

 private:
  class BlockInFlight;

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

  static void tell_slower(const std::function<void(const std::string&)>& tell,
                          const std::string& reason) {
    tell(reason + "; its blocks go through the page cache");
  }

  /// A file system may refuse O_DIRECT only when a transfer comes.
  void give_up_direct() noexcept {
    if (!goes_past_cache_.exchange(false)) return;
    try {
      tell_slower(tell_, file_.path().native() + ": its file system refuses transfers by O_DIRECT");
    } catch (const std::exception&) {  // without memory, nobody is told
    }
  }
  int descriptor(bool past_cache) const noexcept {
    return past_cache ? direct_.descriptor() : file_.descriptor();
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
                        .memory = memory.first(geometry_.block_bytes(block)),
                        .listener = &all};
        memory = memory.subspan(transfers[i].memory.size());
      }
      for (Transfer& transfer : transfers) start(transfer);
      all.wait();
      done += count;
    }
  }

  const LevelGeometry& geometry_;
  BlockTable& table_;
  OpenMode mode_;
  UringRing& ring_;
  PageBuffers& buffers_;
  std::function<void(const std::string&)> tell_;
  File file_;    ///< goes through the page cache
  File direct_;  ///< goes past the page cache
  std::atomic<bool> goes_past_cache_;
};

/// One transfer. The object deletes itself when the transfer has ended.
class UringBackend::BlockInFlight final : public RingRequest {
 public:
  BlockInFlight(UringBackend& backend, Transfer& transfer)
      : backend_(backend),
        transfer_(transfer),
        former_(backend.table_[transfer.block]),
        offset_(backend.geometry_.block_offset(transfer.block)) {
    const std::uint64_t end = offset_ + transfer.memory.size();
    const std::uint64_t first_page = (offset_ + kPageBytes - 1) / kPageBytes * kPageBytes;
    head_bytes_ = std::min(first_page, end) - offset_;
    const std::uint64_t page_bytes =
        end > first_page ? (end - first_page) / kPageBytes * kPageBytes : 0;
    pages_ = transfer.memory.subspan(head_bytes_, page_bytes);
    if (!pages_.empty() && !is_aligned(pages_.data()))
      aligned_ = PageBuffers::Lease(backend.buffers_);
    rest_ = aligned_ ? std::span(aligned_.get(), page_bytes) : pages_;
  }

  void begin() {
    const std::span<std::byte> head = transfer_.memory.first(head_bytes_);
    const std::span<std::byte> tail = transfer_.memory.subspan(head_bytes_ + pages_.size());
    const std::uint64_t tail_offset = offset_ + head_bytes_ + pages_.size();
    if (is_read()) {
      if (!head.empty()) backend_.file_.read_at(offset_, head);
      if (!tail.empty()) backend_.file_.read_at(tail_offset, tail);
    } else {
      if (aligned_) std::memcpy(aligned_.get(), pages_.data(), pages_.size());
      if (!head.empty()) backend_.file_.write_at(offset_, head);
      if (!tail.empty()) backend_.file_.write_at(tail_offset, tail);
      seal_raw(backend_.geometry_, backend_.table_, {transfer_.block, 1}, transfer_.memory);
    }
  }

  /// The object may be deleted when this returns.
  void submit_rest() noexcept {
    if (rest_.empty()) return end(nullptr);
    const FileOperationHook::Verdict verdict = before_operation(operation(rest_.size()));
    if (verdict.error != 0) return completed(-verdict.error);
    if (exceeds_file_limit(operation(rest_.size()))) return completed(-EFBIG);
    // A request moves whole pages, at least one.
    const std::uint64_t most_bytes = std::max(verdict.most_bytes, kPageBytes);
    past_cache_ = backend_.goes_past_cache_;
    backend_.ring_.submit(is_read() ? UringRing::Operation::kRead : UringRing::Operation::kWrite,
                          backend_.descriptor(past_cache_), rest_offset(),
                          rest_.first(std::min<std::uint64_t>(most_bytes, rest_.size())), *this);
  }

  void completed(int result) noexcept override {
    // -ECANCELED: the thread that submitted the request has ended. Submit it again.
    if (result == -EINTR || result == -EAGAIN || result == -ECANCELED) return submit_rest();
    if (result == -EINVAL && past_cache_) {
      backend_.give_up_direct();
      return submit_rest();
    }
    // O_DIRECT continues only at a page boundary. So only the whole pages count as moved.
    const auto moved = static_cast<std::size_t>(std::max(result, 0)) / kPageBytes * kPageBytes;
    if (moved == 0) return end(error_of(result));
    after_operation(operation(moved));
    rest_ = rest_.subspan(moved);
    submit_rest();
  }

  void end(std::exception_ptr error) noexcept {
    if (!error && is_read()) {
      if (aligned_) std::memcpy(pages_.data(), aligned_.get(), pages_.size());
      try {
        check_raw(backend_.geometry_, backend_.table_, {transfer_.block, 1}, transfer_.memory,
                  backend_.file_.path());
      } catch (...) {
        error = caught_exception();
      }
    }
    if (error && !is_read()) backend_.table_.entries()[transfer_.block] = former_;
    Transfer& transfer = transfer_;
    delete this;
    transfer.listener->finished(transfer, error);
  }

 private:
  std::uint64_t rest_offset() const { return offset_ + head_bytes_ + pages_.size() - rest_.size(); }
  FileOperation operation(std::uint64_t bytes) const {
    return {is_read() ? FileOperation::Kind::kRead : FileOperation::Kind::kWrite,
            backend_.file_.path(), rest_offset(), bytes};
  }
  bool is_read() const { return transfer_.direction == Transfer::Direction::kRead; }

  std::exception_ptr error_of(int result) const noexcept {
    const char* const verb = is_read() ? "read" : "write";
    const std::string& path = backend_.file_.path().native();
    try {
      if (result < 0) return std::make_exception_ptr(system_error(verb, path, -result));
      return std::make_exception_ptr(Error(is_read() ? ErrorCode::kCorruption : ErrorCode::kIo,
                                           std::string(verb) + ' ' + path + ": at byte " +
                                               std::to_string(rest_offset()) + " expected " +
                                               std::to_string(rest_.size()) +
                                               " more bytes, found " + std::to_string(result)));
    } catch (...) {
      return caught_exception();
    }
  }

  UringBackend& backend_;
  Transfer& transfer_;
  BlockEntry former_;
  std::uint64_t offset_, head_bytes_ = 0;
  bool past_cache_ = false;     ///< the request that is under way
  std::span<std::byte> pages_;  ///< the transfer's memory for whole pages
  PageBuffers::Lease aligned_;  ///< an aligned copy of pages_; empty if pages_ is aligned
  std::span<std::byte> rest_;   ///< the part of aligned_ or pages_ that is still to be moved
};

void UringBackend::start(Transfer& transfer) noexcept {
  std::unique_ptr<BlockInFlight> made;
  try {
    if (transfer.direction == Transfer::Direction::kWrite) {
      check_writable(file_, mode_);
    } else if (table_[transfer.block].encoding == BlockEncoding::kNeverWritten) {
      std::ranges::fill(transfer.memory, std::byte{0});
      return transfer.listener->finished(transfer, nullptr);
    }
    made = std::make_unique<BlockInFlight>(*this, transfer);
    made->begin();
  } catch (...) {
    const std::exception_ptr error = caught_exception();
    if (made) return made.release()->end(error);
    return transfer.listener->finished(transfer, error);
  }
  made.release()->submit_rest();
}

/// Whether every block of the level begins on a page.
bool blocks_are_aligned(const LevelGeometry& geometry) {
  for (std::uint64_t block = 1; block < geometry.block_count(); ++block)
    if (geometry.block_offset(block) % kPageBytes != 0) return false;
  return true;
}

class UringVolume final : public Volume, public TellingVolume {
 public:
  explicit UringVolume(const VolumeSpec& volume) : buffers_(volume.most_scratch_bytes) {}

  std::unique_ptr<Backend> open_level(const LevelSpec& level) override {
    auto backend = std::make_unique<UringBackend>(
        level, ring_, buffers_, [this](const std::string& line) { keep_first_notice(line); });
    buffers_.make_room_for(page_bytes_of(level.geometry), !blocks_are_aligned(level.geometry));
    return backend;
  }
  std::uint64_t scratch_bytes() const noexcept override { return buffers_.memory_bytes(); }
  std::uint64_t scratch_bytes_with(std::span<const FutureLevel> levels) const override {
    PageBuffers::Room room = buffers_.room();
    std::uint64_t most = buffers_.memory_of(room);
    for (const FutureLevel& level : levels) {
      room =
          buffers_.with(room, page_bytes_of(level.geometry), !blocks_are_aligned(level.geometry));
      most = std::max(most, buffers_.memory_of(room));
    }
    return most;
  }
  std::vector<std::string> notices() const override {
    const std::scoped_lock lock(mutex_);
    return notices_;
  }

 private:
  static std::uint64_t page_bytes_of(const LevelGeometry& level) {
    return (level.max_block_bytes() + kPageBytes - 1) / kPageBytes * kPageBytes;
  }
  /// All levels are on one file system.
  void keep_first_notice(const std::string& line) {
    const std::scoped_lock lock(mutex_);
    if (notices_.empty()) notices_.push_back(line);
  }

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
