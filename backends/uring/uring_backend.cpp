// The bytes of a block, or of a run of adjacent blocks, in the file:
//
//   | head | whole pages ...                            | tail |
//
// Head and tail are parts of pages that it shares with its neighbours. Both are empty if all
// blocks of the level begin and end at page boundaries. Whole pages go past the page cache. Shared
// pages always go through the page cache: there the kernel combines the parts, even if several
// threads write them at the same time. No byte is ever accessed both ways.
#include <algorithm>
#include <atomic>
#include <boost/container/small_vector.hpp>
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
#include "plait/detail/level_file.h"
#include "plait/error.h"
#include "uring/page_buffers.h"
#include "uring/pread_instead.h"
#include "uring/uring_ring.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// Whether O_DIRECT can move this piece of a run.
bool is_aligned(std::span<const std::byte> piece) {
  return reinterpret_cast<std::uintptr_t>(piece.data()) % kPageBytes == 0 &&
         piece.size() % kPageBytes == 0;
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
  /// A page buffer has room for `run_bytes` bytes of a run, or for one block if that is 0.
  UringBackend(const LevelSpec& level, UringRing& ring, PageBuffers& buffers,
               std::uint64_t run_bytes, const std::function<void(const std::string&)>& tell)
      : geometry_(level.geometry),
        table_(level.table),
        mode_(level.mode),
        ring_(ring),
        buffers_(buffers),
        buffered_run_bytes_(run_bytes),
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

  void start(Transfer& transfer) noexcept override {
    Transfer* const only = &transfer;
    start_run({&only, 1});
  }
  void start_run(std::span<Transfer* const> run) noexcept override;

  void advise(BlockRange, Advice) noexcept override {}
  void sync(bool durable) override {
    if (durable) file_.sync();
  }
  std::uint64_t stored_bytes() const override { return fixed_file_bytes(geometry_); }

 private:
  class RunInFlight;
  /// Begins transfers that go out in one request. `aligned` is a page buffer that they may need.
  void start_together(std::span<Transfer* const> run, PageBuffers::Lease aligned) noexcept;
  /// How many transfers at the beginning of a run can go out in one request.
  std::size_t together(std::span<Transfer* const> run) const noexcept;
  bool reads_as_zeros(const Transfer& transfer) const noexcept {
    return transfer.direction == Transfer::Direction::kRead &&
           table_[transfer.block].encoding == BlockEncoding::kNeverWritten;
  }
  /// Whether O_DIRECT can move the block from where it is to where it is to be, whatever comes
  /// before or behind it.
  bool is_in_place(const Transfer& transfer) const noexcept {
    return geometry_.block_offset(transfer.block) % kPageBytes == 0 && is_aligned(transfer.memory);
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
  std::uint64_t buffered_run_bytes_;
  std::function<void(const std::string&)> tell_;
  File file_;    ///< goes through the page cache
  File direct_;  ///< goes past the page cache
  std::atomic<bool> goes_past_cache_;
};

/// The transfers of one request. The object deletes itself when they have ended.
class UringBackend::RunInFlight final : public RingRequest {
 public:
  RunInFlight(UringBackend& backend, std::span<Transfer* const> run, PageBuffers::Lease aligned)
      : backend_(backend),
        run_(run.begin(), run.end()),
        is_read_(run.front()->direction == Transfer::Direction::kRead),
        offset_(backend.geometry_.block_offset(run.front()->block)),
        aligned_(std::move(aligned)) {
    for (const Transfer* const transfer : run_) {
      former_.push_back(backend.table_[transfer->block]);
      bytes_ += transfer->memory.size();
    }
    const std::uint64_t end = offset_ + bytes_;
    const std::uint64_t first_page = (offset_ + kPageBytes - 1) / kPageBytes * kPageBytes;
    head_bytes_ = std::min(first_page, end) - offset_;
    page_bytes_ = end > first_page ? (end - first_page) / kPageBytes * kPageBytes : 0;
    for_each_piece(head_bytes_, page_bytes_,
                   [&](std::span<std::byte> piece) { rest_.push_back(piece); });
    in_place_ = std::ranges::all_of(rest_, is_aligned);
    if (!in_place_) {
      if (!aligned_) aligned_ = PageBuffers::Lease(backend.buffers_);
      rest_.assign(1, {aligned_.get(), page_bytes_});
    }
    vectors_.resize(rest_.size());
  }

  void begin() {
    const std::uint64_t tail_at = head_bytes_ + page_bytes_;
    const auto shared = [&](auto move) {
      std::uint64_t at = offset_;
      const auto move_piece = [&](std::span<std::byte> piece) {
        move(at, piece);
        at += piece.size();
      };
      for_each_piece(0, head_bytes_, move_piece);
      at = offset_ + tail_at;
      at_tail_ = true;
      for_each_piece(tail_at, bytes_ - tail_at, move_piece);
    };
    if (is_read())
      return shared(
          [&](std::uint64_t at, std::span<std::byte> piece) { backend_.file_.read_at(at, piece); });
    if (!in_place_)
      copy_pages([](std::byte* buffer, std::span<std::byte> piece) {
        std::memcpy(buffer, piece.data(), piece.size());
      });
    shared(
        [&](std::uint64_t at, std::span<std::byte> piece) { backend_.file_.write_at(at, piece); });
    for (const Transfer* const transfer : run_)
      seal_raw(backend_.geometry_, backend_.table_, {transfer->block, 1}, transfer->memory);
  }

  /// The object may be deleted when this returns.
  void submit_rest() noexcept {
    if (rest_bytes() == 0) return end(nullptr);
    const FileOperationHook::Verdict verdict = before_operation(operation(rest_bytes()));
    if (verdict.error != 0) return completed(-verdict.error);
    if (exceeds_file_limit(operation(rest_bytes()))) return completed(-EFBIG);
    // A request moves whole pages, at least one.
    std::uint64_t most_bytes =
        std::max(verdict.most_bytes / kPageBytes, std::uint64_t{1}) * kPageBytes;
    past_cache_ = backend_.goes_past_cache_;
    std::size_t count = 0;
    for (const std::span<std::byte> piece : rest_) {
      if (most_bytes == 0) break;
      const std::uint64_t bytes = std::min<std::uint64_t>(piece.size(), most_bytes);
      if (bytes > 0) vectors_[count++] = {piece.data(), bytes};
      most_bytes -= bytes;
    }
    const auto kind = is_read() ? UringRing::Operation::kRead : UringRing::Operation::kWrite;
    const int descriptor = backend_.descriptor(past_cache_);
    if (count == 1)
      backend_.ring_.submit(
          kind, descriptor, rest_offset(),
          std::span(static_cast<std::byte*>(vectors_[0].iov_base), vectors_[0].iov_len), *this);
    else
      backend_.ring_.submit(kind, descriptor, rest_offset(),
                            std::span<const iovec>(vectors_.data(), count), *this);
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
    moved_bytes_ += moved;
    std::size_t left = moved;
    for (std::span<std::byte>& piece : rest_) {
      const std::size_t taken = std::min(left, piece.size());
      piece = piece.subspan(taken);
      left -= taken;
    }
    submit_rest();
  }

  /// With an error, the transfers before the one in which the request stopped have succeeded, and
  /// those behind it begin again.
  void end(const std::exception_ptr& error) noexcept {
    const std::unique_ptr<RunInFlight> ends_here(this);
    if (is_read() && !in_place_)
      copy_pages([](const std::byte* buffer, std::span<std::byte> piece) {
        std::memcpy(piece.data(), buffer, piece.size());
      });
    const std::uint64_t stopped = error ? head_bytes_ + moved_bytes_ : bytes_;
    std::size_t good = 0;
    for (std::uint64_t at = 0; good < run_.size(); ++good) {
      at += run_[good]->memory.size();
      if (at > stopped) break;
    }
    if (!is_read())
      for (std::size_t i = good; i < run_.size(); ++i)
        backend_.table_.entries()[run_[i]->block] = former_[i];
    const bool goes_on = good + 1 < run_.size();
    // When the last transfer has ended, there may be no backend any more.
    if (!goes_on) give_buffer_back();
    for (Transfer* const transfer : run().first(good)) {
      std::exception_ptr damage;
      try {
        if (is_read())
          check_raw(backend_.geometry_, backend_.table_, {transfer->block, 1}, transfer->memory,
                    backend_.file_.path());
      } catch (...) {
        damage = caught_exception();
      }
      transfer->listener->finished(*transfer, damage);
    }
    if (good < run_.size()) run_[good]->listener->finished(*run_[good], error);
    if (goes_on) backend_.start_together(run().subspan(good + 1), std::move(aligned_));
  }

  /// begin() failed. After a failed write nothing more is written. Of a read, the pages of the
  /// first or of the last block failed, and the others begin again.
  void end_unbegun(const std::exception_ptr& error) noexcept {
    const std::unique_ptr<RunInFlight> ends_here(this);
    const bool goes_on = is_read() && run_.size() > 1;
    if (!goes_on) give_buffer_back();
    std::span<Transfer* const> rest = run();
    Transfer* const failed = at_tail_ ? rest.back() : rest.front();
    rest = at_tail_ ? rest.first(rest.size() - 1) : rest.subspan(1);
    if (!goes_on)
      for (Transfer* const transfer : rest) transfer->listener->finished(*transfer, error);
    failed->listener->finished(*failed, error);
    if (goes_on) backend_.start_together(rest, std::move(aligned_));
  }

 private:
  /// Calls `visit(piece)` for the pieces of the transfers' memory that have these bytes of the run.
  template <class Visit>
  void for_each_piece(std::uint64_t first, std::uint64_t count, Visit visit) const {
    for (const Transfer* const transfer : run_) {
      const std::uint64_t size = transfer->memory.size();
      if (first < size && count > 0) {
        const std::uint64_t bytes = std::min(count, size - first);
        visit(transfer->memory.subspan(first, bytes));
        first += bytes;
        count -= bytes;
      }
      first -= std::min(first, size);
    }
  }
  /// `copy(buffer, piece)` for the whole pages.
  template <class Copy>
  void copy_pages(Copy copy) const {
    std::byte* buffer = aligned_.get();
    for_each_piece(head_bytes_, page_bytes_, [&](std::span<std::byte> piece) {
      copy(buffer, piece);
      buffer += piece.size();
    });
  }

  std::span<Transfer* const> run() const noexcept { return {run_.data(), run_.size()}; }
  void give_buffer_back() noexcept { const PageBuffers::Lease ends_here(std::move(aligned_)); }
  std::uint64_t rest_bytes() const noexcept { return page_bytes_ - moved_bytes_; }
  std::uint64_t rest_offset() const noexcept { return offset_ + head_bytes_ + moved_bytes_; }
  FileOperation operation(std::uint64_t bytes) const {
    return {is_read() ? FileOperation::Kind::kRead : FileOperation::Kind::kWrite,
            backend_.file_.path(), rest_offset(), bytes};
  }
  bool is_read() const { return is_read_; }

  std::exception_ptr error_of(int result) const noexcept {
    const char* const verb = is_read() ? "read" : "write";
    const std::string& path = backend_.file_.path().native();
    try {
      if (result < 0) return std::make_exception_ptr(system_error(verb, path, -result));
      return std::make_exception_ptr(Error(is_read() ? ErrorCode::kCorruption : ErrorCode::kIo,
                                           std::string(verb) + ' ' + path + ": at byte " +
                                               std::to_string(rest_offset()) + " expected " +
                                               std::to_string(rest_bytes()) +
                                               " more bytes, found " + std::to_string(result)));
    } catch (...) {
      return caught_exception();
    }
  }

  using Vectors = boost::container::small_vector<iovec, 1>;

  UringBackend& backend_;
  boost::container::small_vector<Transfer*, 1> run_;
  boost::container::small_vector<BlockEntry, 1> former_;
  bool is_read_;
  std::uint64_t offset_, bytes_ = 0, head_bytes_ = 0, page_bytes_ = 0;
  std::uint64_t moved_bytes_ = 0;  ///< of the whole pages
  bool in_place_ = true;
  bool at_tail_ = false;        ///< begin() has moved the head
  bool past_cache_ = false;     ///< the request that is under way
  PageBuffers::Lease aligned_;  ///< an aligned copy of the whole pages, if they are not in place
  /// What is still to be moved of the whole pages, in their copy or where they are.
  boost::container::small_vector<std::span<std::byte>, 1> rest_;
  Vectors vectors_;  ///< as many as rest_; the first ones are of the request that is under way
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
      start_together(run.first(count), {});
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

void UringBackend::start_together(std::span<Transfer* const> run,
                                  PageBuffers::Lease aligned) noexcept {
  std::unique_ptr<RunInFlight> made;
  try {
    if (run.front()->direction == Transfer::Direction::kWrite) check_writable(file_, mode_);
    made = std::make_unique<RunInFlight>(*this, run, std::move(aligned));
    made->begin();
  } catch (...) {
    const std::exception_ptr error = caught_exception();
    if (made) return made.release()->end_unbegun(error);
    for (Transfer* const transfer : run) transfer->listener->finished(*transfer, error);
    return;
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
