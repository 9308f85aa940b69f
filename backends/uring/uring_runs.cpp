// The bytes of a block, or of a run of adjacent blocks, in the file:
//
//   | head | whole pages ...                            | tail |
//
// Head and tail are parts of pages that it shares with its neighbours. Both are empty if all
// blocks of the level begin and end at page boundaries. Whole pages go past the page cache. Shared
// pages always go through the page cache: there the kernel combines the parts, even if several
// threads write them at the same time. No byte is ever accessed both ways.
#include "uring/uring_runs.h"

#include <algorithm>
#include <boost/container/small_vector.hpp>
#include <cerrno>
#include <cstring>
#include <memory>
#include <string>

#include "base/caught.h"
#include "io/file_operations.h"
#include "io/system_call.h"
#include "level_file.h"
#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// The transfers of one request. The object deletes itself when they have ended.
class RunInFlight final : public RingRequest {
 public:
  RunInFlight(UringLevel& level, std::span<Transfer* const> run, PageBuffers::Lease aligned)
      : level_(level),
        run_(run.begin(), run.end()),
        is_read_(run.front()->direction == Transfer::Direction::kRead),
        offset_(level.first_byte + level.geometry.block_offset(run.front()->block)),
        aligned_(std::move(aligned)) {
    for (const Transfer* const transfer : run_) {
      former_.push_back(level.table[transfer->block]);
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
      if (!aligned_) aligned_ = PageBuffers::Lease(level.buffers);
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
          [&](std::uint64_t at, std::span<std::byte> piece) { level_.file.read_at(at, piece); });
    if (!in_place_)
      copy_pages([](std::byte* buffer, std::span<std::byte> piece) {
        std::memcpy(buffer, piece.data(), piece.size());
      });
    shared([&](std::uint64_t at, std::span<std::byte> piece) { level_.file.write_at(at, piece); });
    for (const Transfer* const transfer : run_)
      seal_raw(level_.geometry, level_.table, {transfer->block, 1}, transfer->memory,
               level_.first_byte);
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
    past_cache_ = level_.goes_past_cache;
    std::size_t count = 0;
    for (const std::span<std::byte> piece : rest_) {
      if (most_bytes == 0) break;
      const std::uint64_t bytes = std::min<std::uint64_t>(piece.size(), most_bytes);
      if (bytes > 0) vectors_[count++] = {piece.data(), bytes};
      most_bytes -= bytes;
    }
    const auto kind = is_read() ? UringRing::Operation::kRead : UringRing::Operation::kWrite;
    const int descriptor = level_.descriptor(past_cache_);
    if (count == 1)
      level_.ring.submit(
          kind, descriptor, rest_offset(),
          std::span(static_cast<std::byte*>(vectors_[0].iov_base), vectors_[0].iov_len), *this);
    else
      level_.ring.submit(kind, descriptor, rest_offset(),
                         std::span<const iovec>(vectors_.data(), count), *this);
  }

  void completed(int result) noexcept override {
    // -ECANCELED: the thread that submitted the request has ended. Submit it again.
    if (result == -EINTR || result == -EAGAIN || result == -ECANCELED) return submit_rest();
    if (result == -EINVAL && past_cache_) {
      level_.give_up_direct();
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
        level_.table.entries()[run_[i]->block] = former_[i];
    const bool goes_on = good + 1 < run_.size();
    // When the last transfer has ended, there may be no level any more.
    if (!goes_on) give_buffer_back();
    for (Transfer* const transfer : run().first(good)) {
      std::exception_ptr damage;
      try {
        if (is_read())
          check_raw(level_.geometry, level_.table, {transfer->block, 1}, transfer->memory,
                    level_.file.path());
      } catch (...) {
        damage = caught_exception();
      }
      transfer->listener->finished(*transfer, damage);
    }
    if (good < run_.size()) run_[good]->listener->finished(*run_[good], error);
    if (goes_on) start_together(level_, run().subspan(good + 1), std::move(aligned_));
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
    if (goes_on) start_together(level_, rest, std::move(aligned_));
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
            level_.file.path(), rest_offset(), bytes};
  }
  bool is_read() const { return is_read_; }

  std::exception_ptr error_of(int result) const noexcept {
    const char* const verb = is_read() ? "read" : "write";
    const std::string& path = level_.file.path().native();
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

  UringLevel& level_;
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

}  // namespace

bool is_aligned(std::span<const std::byte> piece) noexcept {
  return reinterpret_cast<std::uintptr_t>(piece.data()) % kPageBytes == 0 &&
         piece.size() % kPageBytes == 0;
}

void start_together(UringLevel& level, std::span<Transfer* const> run,
                    PageBuffers::Lease aligned) noexcept {
  std::unique_ptr<RunInFlight> made;
  try {
    if (run.front()->direction == Transfer::Direction::kWrite)
      check_writable(level.file, level.mode);
    made = std::make_unique<RunInFlight>(level, run, std::move(aligned));
    made->begin();
  } catch (...) {
    const std::exception_ptr error = caught_exception();
    if (made) return made.release()->end_unbegun(error);
    for (Transfer* const transfer : run) transfer->listener->finished(*transfer, error);
    return;
  }
  made.release()->submit_rest();
}

void UringLevel::give_up_direct() noexcept {
  if (!goes_past_cache.exchange(false)) return;
  try {
    tell_slower(tell, file.path().native() + ": its file system refuses transfers by O_DIRECT");
  } catch (const std::exception&) {  // without memory, nobody is told
  }
}

PLAIT_END_NAMESPACE
