#include <fmt/format.h>
#include <sys/mman.h>

#include <boost/interprocess/exceptions.hpp>
#include <boost/interprocess/mapped_region.hpp>
#include <cerrno>
#include <memory>
#include <mutex>
#include <string>
#include <system_error>
#include <vector>

#include "base/caught.h"
#include "blocks/telling_volume.h"
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

/// The file system maps no files, as some of FUSE and 9p do.
class CannotMap : public Error {
 public:
  explicit CannotMap(const Error& error) : Error(error) {}
};

[[noreturn]] void throw_unmapped(const File& file, std::uint64_t bytes, int error,
                                 const std::string& why) {
  const Error failure =
      Error(ErrorCode::kIo, fmt::format("map {}: {} bytes: {}", file.path().native(), bytes, why))
          .about(file.path());
  if (error == ENODEV || error == ENOSYS || error == EOPNOTSUPP) throw CannotMap(failure);
  throw failure;
}

interprocess::mapped_region map_file(const File& file, std::uint64_t first_byte,
                                     std::uint64_t bytes) {
  if (bytes == 0) return {};
  if (const int error = before_operation({FileOperation::Kind::kMap, file.path()}).error;
      error != 0)
    throw_unmapped(file, bytes, error, std::generic_category().message(error));
  try {
    return {OpenedFile{file.descriptor()}, interprocess::read_only,
            static_cast<interprocess::offset_t>(first_byte), bytes};
  } catch (const interprocess::interprocess_exception& failure) {
    throw_unmapped(file, bytes, failure.get_native_error(), failure.what());
  }
}

/// A level that was opened for reading.
class MappedLevel final : public Backend {
 public:
  explicit MappedLevel(const LevelSpec& level)
      : geometry_(level.geometry),
        table_(level.table),
        first_byte_(level.first_byte),
        file_(open_fixed_file(level)),
        region_(map_file(file_, first_byte_, fixed_file_bytes(geometry_))) {}

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
    const std::uint64_t expected = first_byte_ + fixed_file_bytes(geometry_);
    if (const std::uint64_t found = file_.size(); found < expected)
      throw Error(ErrorCode::kCorruption,
                  fmt::format("access {}: expected {} bytes, found {}: the file was cut short",
                              file_.path().native(), expected, found))
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
          {FileOperation::Kind::kRead, file_.path(), first_byte_ + at, end - at},
          [&](std::uint64_t most_bytes) {
            return map_pages(static_cast<std::byte*>(region_.get_address()) + at, most_bytes);
          });
      if (mapped < 0) throw system_error("read", file_.path().native(), errno, first_byte_ + at);
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
  std::uint64_t first_byte_;  ///< in the file; offsets in region_ count from it
  File file_;
  interprocess::mapped_region region_;
};

class MmapVolume final : public Volume, public TellingVolume {
 public:
  std::unique_ptr<Backend> open_level(const LevelSpec& level) override {
    if (level.mode != OpenMode::kRead) return open_pread_backend(level);
    try {
      return std::make_unique<MappedLevel>(level);
    } catch (const CannotMap& error) {
      const std::scoped_lock lock(mutex_);
      if (notice_.empty())
        notice_ = std::string(error.what()) + "; using pread instead, whose files are the same";
    }
    return open_pread_backend(level);
  }
  std::vector<std::string> notices() const override {
    const std::scoped_lock lock(mutex_);
    return notice_.empty() ? std::vector<std::string>() : std::vector{notice_};
  }

 private:
  mutable std::mutex mutex_;  ///< of notice_
  std::string notice_;        ///< of the first level that could not be mapped
};

}  // namespace

std::unique_ptr<Volume> open_mmap_volume(const VolumeSpec&) {
  return std::make_unique<MmapVolume>();
}

PLAIT_END_NAMESPACE
