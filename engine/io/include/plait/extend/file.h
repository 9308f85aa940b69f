// plait/extend/file.h: files of the operating system. The library opens, reads and writes files
// through this class only. Every operation calls the hook of io/file_operations.h, which tests use.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>

#include "plait/detail/namespace.h"
#include "plait/error.h"

PLAIT_BEGIN_NAMESPACE

class Directory;

enum class OpenMode : std::uint8_t {
  kRead,       ///< must exist
  kReadWrite,  ///< must exist
  kCreate,     ///< read and write; must not exist
};

enum class Caching : std::uint8_t {
  kPageCache,
  kNone,  ///< O_DIRECT: offsets, sizes and memory must be multiples of 4096
};

/// A file descriptor. read_at() and write_at() transfer all bytes or throw: they continue after an
/// interrupted or a short system call, and a read past the end is an error. Threads:
/// read_at() and write_at() are shared (docs/threads.md).
class File {
 public:
  File() = default;
  /// Opening a FIFO does not block. Errors: kNotFound, kIo, kNoSpace; kInvalidArgument for anything
  /// but a regular file (the message names its kind); kNotSupported if the file system has no
  /// O_DIRECT.
  File(const std::filesystem::path& path, OpenMode mode, Caching caching = Caching::kPageCache);
  /// Opens the file `name` of a directory. It must be a regular file, not a symbolic link to one.
  /// Errors: as above, but kCorruption for anything but a regular file.
  File(const Directory& directory, const std::string& name, OpenMode mode,
       Caching caching = Caching::kPageCache);
  ~File();
  File(File&& other) noexcept;
  File& operator=(File&& other) noexcept;

  bool is_open() const noexcept { return descriptor_ >= 0; }
  const std::filesystem::path& path() const noexcept { return path_; }
  int descriptor() const noexcept { return descriptor_; }

  /// Errors: kIo; kCorruption if the file ends before the last byte of the range.
  void read_at(std::uint64_t offset, std::span<std::byte> into) const;
  /// Errors: kIo, kNoSpace.
  void write_at(std::uint64_t offset, std::span<const std::byte> from);
  /// One call that moves bytes between the file, from `offset` on, and pieces of memory, one after
  /// another; of more than kMostPieces pieces, the first ones. Returns how many bytes it moved: at
  /// least one, and maybe fewer than the pieces have. REQUIRES: no piece is empty. Errors: as
  /// read_at() and write_at().
  static constexpr std::size_t kMostPieces = 256;
  std::uint64_t read_some(std::uint64_t offset, std::span<const std::span<std::byte>> pieces) const;
  std::uint64_t write_some(std::uint64_t offset, std::span<const std::span<std::byte>> pieces);
  std::uint64_t size() const;
  void resize(std::uint64_t bytes);
  /// Allocates the first `bytes` bytes on the disk (posix_fallocate), so that a full disk is an
  /// error now and not during a later write. Does nothing where the file system cannot allocate.
  void preallocate(std::uint64_t bytes);
  void sync();
  /// Takes a lock with flock. The operating system releases the lock when the last descriptor of
  /// this open file closes, also when the process is killed. Returns false if another lock
  /// conflicts. Errors: kIo; kNotSupported if the file system has no locks.
  bool lock(bool exclusive);
  /// Closes the file and throws if that fails. The destructor closes too, but cannot report an
  /// error.
  void close();

 private:
  /// The arguments of openat, and the error code for an entry that is not a regular file.
  struct OpenTarget {
    int directory;
    const char* name;
    int flags;
    ErrorCode other_kinds;
  };
  void open(const OpenTarget& target, OpenMode mode, Caching caching);

  std::filesystem::path path_;
  int descriptor_ = -1;
};

/// Opens the file `name` of a directory, or returns nothing if the directory has no such entry: for
/// a file that another process may remove at any moment. Errors: as File's constructor has them,
/// without kNotFound.
std::optional<File> open_if_present(const Directory& directory, const std::string& name,
                                    OpenMode mode);

PLAIT_END_NAMESPACE
