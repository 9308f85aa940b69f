#include <fmt/format.h>
#include <sys/mman.h>

#include <boost/interprocess/exceptions.hpp>
#include <boost/interprocess/mapped_region.hpp>
#include <cerrno>

#include "base/caught.h"
#include "built_in_backends.h"
#include "io/file_operations.h"
#include "io/system_call.h"
#include "level_file.h"
#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

namespace interprocess = boost::interprocess;

/// What mapped_region maps: an open file. (file_mapping of Boost opens a path, and another file may
/// have the name by now.)
struct OpenedFile {
  int descriptor;
  interprocess::mapping_handle_t get_mapping_handle() const { return {descriptor, false}; }
};

interprocess::mapped_region map_file(const File& file, std::uint64_t bytes) {
  if (bytes == 0) return {};
  if (const int error = before_operation({FileOperation::Kind::kMap, file.path()}).error;
      error != 0)
    throw system_error("map", file.path().native(), error);
  try {
    return {OpenedFile{file.descriptor()}, interprocess::read_only, 0, bytes};
  } catch (const interprocess::interprocess_exception& failure) {
    throw Error(ErrorCode::kIo,
                fmt::format("map {}: {} bytes: {}", file.path().native(), bytes, failure.what()))
        .about(file.path());
  }
}

/// A level that was opened for reading.
class MappedLevel final : public Backend {
 public:
  explicit MappedLevel(const LevelSpec& level)
      : geometry_(level.geometry),
        table_(level.table),
        file_(open_fixed_file(level)),
        region_(map_file(file_, fixed_file_bytes(geometry_))) {}

  void read(BlockRange blocks, std::span<std::byte> into) override {
    check_request(geometry_, blocks, into.size());
    const std::byte* const from = address(blocks.first);
    bring_in(fixed_bytes(geometry_, blocks));
    copy_unless_same(from, into.data(), into.size());
    check_raw(geometry_, table_, blocks, into, file_.path());
  }

  void start_run(std::span<Transfer* const> run) noexcept override {
    // What a call does not map, each block maps by itself, and then gets its own error.
    try {
      if (run.front()->direction == Transfer::Direction::kRead)
        bring_in(fixed_bytes(geometry_, {run.front()->block, run.size()}));
    } catch (const std::exception&) {
      return Backend::start_run(run);
    }
    for (Transfer* const transfer : run) {
      std::exception_ptr error;
      try {
        if (transfer->direction == Transfer::Direction::kWrite)
          check_writable(file_, OpenMode::kRead);
        copy_unless_same(address(transfer->block), transfer->memory.data(),
                         transfer->memory.size());
        check_raw(geometry_, table_, {transfer->block, 1}, transfer->memory, file_.path());
      } catch (...) {
        error = caught_exception();
      }
      transfer->listener->finished(*transfer, error);
    }
  }

  void write(BlockRange blocks, std::span<const std::byte> from) override {
    check_writable(file_, OpenMode::kRead);
    check_request(geometry_, blocks, from.size());
  }

  std::byte* address(std::uint64_t block) override {
    // Access to a mapping beyond the end of its file kills the process (SIGBUS).
    if (const std::uint64_t found = file_.size(); found < fixed_file_bytes(geometry_))
      throw Error(ErrorCode::kCorruption,
                  fmt::format("access {}: expected {} bytes, found {}: the file was cut short",
                              file_.path().native(), fixed_file_bytes(geometry_), found))
          .about(file_.path(), found);
    return static_cast<std::byte*>(region_.get_address()) + geometry_.block_offset(block);
  }

  void advise(BlockRange blocks, Advice advice) noexcept override {
    // MADV_SEQUENTIAL makes a sweep under a memory limit two to four times slower
    // (docs/benchmarks.md).
    if (advice != Advice::kDontNeed) return;
    // The pages stay in the page cache. The range has only whole pages of these blocks, because the
    // neighbouring blocks may still be in use.
    const ByteRange bytes = fixed_bytes(geometry_, blocks);
    const std::uint64_t first = (bytes.first + kPageBytes - 1) / kPageBytes * kPageBytes;
    const std::uint64_t end = (bytes.first + bytes.count) / kPageBytes * kPageBytes;
    if (first < end)
      ::madvise(static_cast<std::byte*>(region_.get_address()) + first, end - first, MADV_DONTNEED);
  }

  void sync(bool) override {}  // nothing was written
  std::uint64_t stored_bytes() const override { return fixed_file_bytes(geometry_); }

 private:
  /// Maps the pages of these bytes. What a disk cannot read, and what is no longer in the file, is
  /// an error here; where a page is touched for the first time it would be a signal (SIGBUS).
  void bring_in(ByteRange bytes) {
    const std::uint64_t end = bytes.first + bytes.count;
    for (std::uint64_t at = bytes.first / kPageBytes * kPageBytes; at < end;) {
      const ssize_t mapped = attempt(
          {FileOperation::Kind::kRead, file_.path(), at, end - at}, [&](std::uint64_t most_bytes) {
            return map_pages(static_cast<std::byte*>(region_.get_address()) + at, most_bytes);
          });
      if (mapped < 0) throw system_error("read", file_.path().native(), errno, at);
      at += (static_cast<std::uint64_t>(mapped) + kPageBytes - 1) / kPageBytes * kPageBytes;
    }
  }

  /// Returns the bytes, or -1 with errno.
  static ssize_t map_pages(std::byte* first, std::uint64_t bytes) noexcept {
#ifdef MADV_POPULATE_READ
    if (::madvise(first, bytes, MADV_POPULATE_READ) != 0) {
      // EFAULT stands for the signal. EINVAL: Linux before 5.14 cannot ask.
      if (errno == EFAULT || errno == EHWPOISON) errno = EIO;
      if (errno != EINVAL) return -1;
    }
#endif
    return static_cast<ssize_t>(bytes);
  }

  const LevelGeometry& geometry_;
  const BlockTable& table_;
  File file_;
  interprocess::mapped_region region_;
};

}  // namespace

std::unique_ptr<Backend> open_mmap_backend(const LevelSpec& level) {
  if (level.mode == OpenMode::kRead) return std::make_unique<MappedLevel>(level);
  return open_pread_backend(level);
}

PLAIT_END_NAMESPACE
