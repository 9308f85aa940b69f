// plait/file.h: the one door to the operating system's files. Every operation passes
// plait/file_operations.h, where tests can stand.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

#include "plait/error.h"

namespace plait {

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

/// A file descriptor. Whole transfers only: interrupted and short ones are continued, and a read
/// past the end is an error. Positioned calls are safe from any number of threads.
class File {
 public:
  File() = default;
  /// Never waits for a FIFO. Errors: kNotFound, kIo, kNoSpace; kInvalidArgument, saying what it is,
  /// for something that is no regular file; kNotSupported where there is no O_DIRECT.
  File(const std::filesystem::path& path, OpenMode mode, Caching caching = Caching::kPageCache);
  /// The file `name` of a directory, where it must be a regular file and no link to one.
  /// Errors: likewise, but kCorruption for something that is no regular file.
  File(const Directory& directory, const std::string& name, OpenMode mode,
       Caching caching = Caching::kPageCache);
  ~File();
  File(File&& other) noexcept;
  File& operator=(File&& other) noexcept;

  bool is_open() const noexcept { return descriptor_ >= 0; }
  const std::filesystem::path& path() const noexcept { return path_; }
  int descriptor() const noexcept { return descriptor_; }

  /// Errors: kIo; kCorruption where the file ends before the last byte asked for.
  void read_at(std::uint64_t offset, std::span<std::byte> into) const;
  /// Errors: kIo, kNoSpace.
  void write_at(std::uint64_t offset, std::span<const std::byte> from);
  std::uint64_t size() const;
  void resize(std::uint64_t bytes);
  /// Makes the first `bytes` bytes exist on the disk, so that a full one is an error now
  /// (posix_fallocate).
  void preallocate(std::uint64_t bytes);
  void sync();
  /// flock, which ends with the last descriptor of this open, whatever becomes of the process.
  /// False: somebody else's lock is in the way. Errors: kIo.
  bool lock(bool exclusive);
  /// Reports what the destructor would have to swallow.
  void close();

 private:
  /// What openat takes, and the error for what is there and no regular file.
  struct Place {
    int directory;
    const char* name;
    int flags;
    ErrorCode other_kinds;
  };
  void open(const Place& place, OpenMode mode, Caching caching);

  std::filesystem::path path_;
  int descriptor_ = -1;
};

}  // namespace plait
