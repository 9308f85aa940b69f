#include "plait/extend/file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <string_view>
#include <utility>

#include "io/descriptor.h"
#include "io/locks.h"
#include "io/process.h"
#include "io/system_call.h"
#include "plait/error.h"
#include "plait/extend/directory.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

using Kind = FileOperation::Kind;

int opening_flags(OpenMode mode) {
  switch (mode) {
    case OpenMode::kRead:
      return O_RDONLY;
    case OpenMode::kReadWrite:
      return O_RDWR;
    case OpenMode::kCreate:
      return O_RDWR | O_CREAT | O_EXCL;
  }
  return O_RDONLY;
}

std::string_view kind_of(mode_t mode) {
  if (S_ISDIR(mode)) return "a directory";
  if (S_ISLNK(mode)) return "a symbolic link";
  if (S_ISFIFO(mode)) return "a FIFO";
  if (S_ISSOCK(mode)) return "a socket";
  if (S_ISCHR(mode) || S_ISBLK(mode)) return "a device";
  return "something else";
}

/// Throws unless the file is a regular file.
void refuse_other_kinds(const struct stat& status, const std::filesystem::path& path,
                        ErrorCode code) {
  if (S_ISREG(status.st_mode)) return;
  throw Error(code, fmt::format("open {}: expected a regular file, found {}", path.native(),
                                kind_of(status.st_mode)))
      .about(path);
}

/// Pieces of memory as a system call takes them.
class Pieces {
 public:
  explicit Pieces(std::span<const std::span<std::byte>> pieces) noexcept {
    for (const std::span<std::byte> piece :
         pieces.first(std::min(pieces.size(), File::kMostPieces))) {
      vectors_[count_++] = {piece.data(), piece.size()};
      bytes_ += piece.size();
    }
  }
  std::uint64_t bytes() const noexcept { return bytes_; }
  /// The first `most_bytes` bytes.
  std::span<const iovec> first(std::uint64_t most_bytes) noexcept {
    std::size_t count = 0;
    while (count < count_ && most_bytes > vectors_[count].iov_len)
      most_bytes -= vectors_[count++].iov_len;
    if (count < count_) vectors_[count].iov_len = std::min(vectors_[count].iov_len, most_bytes);
    return {vectors_.data(), std::min(count + 1, count_)};
  }

 private:
  std::array<iovec, File::kMostPieces> vectors_;
  std::size_t count_ = 0;
  std::uint64_t bytes_ = 0;
};

}  // namespace

File::File(const std::filesystem::path& path, OpenMode mode, Caching caching) : path_(path) {
  open({AT_FDCWD, path.c_str(), 0, ErrorCode::kInvalidArgument}, mode, caching);
}

File::File(const Directory& directory, const std::string& name, OpenMode mode, Caching caching)
    : path_(directory.path_of(name)) {
  open({directory.descriptor(), name.c_str(), O_NOFOLLOW, ErrorCode::kCorruption}, mode, caching);
}

void File::open(const OpenTarget& target, OpenMode mode, Caching caching) {
  // Without O_NONBLOCK, opening a FIFO blocks until another process opens its other end.
  const int flags = opening_flags(mode) | target.flags | O_CLOEXEC | O_NONBLOCK |
                    (caching == Caching::kNone ? O_DIRECT : 0);
  const FileOperation operation{mode == OpenMode::kCreate ? Kind::kCreate : Kind::kOpen, path_};
  File opened;
  opened.descriptor_ = static_cast<int>(attempt(operation, [&](auto) {
    return above_standard_streams(::openat(target.directory, target.name, flags, 0666));
  }));
  struct stat status {};
  if (opened.descriptor_ < 0) {
    const int error = errno;
    if (mode != OpenMode::kCreate && ::fstatat(target.directory, target.name, &status,
                                               target.flags != 0 ? AT_SYMLINK_NOFOLLOW : 0) == 0)
      refuse_other_kinds(status, path_, target.other_kinds);
    if (error == EINVAL && caching == Caching::kNone)
      throw Error(ErrorCode::kNotSupported,
                  fmt::format("open {}: its file system has no O_DIRECT", path_.native()))
          .about(path_);
    throw system_error(mode == OpenMode::kCreate ? "create" : "open", path_.native(), error);
  }
  if (::fstat(opened.descriptor_, &status) != 0) throw system_error("stat", path_.native(), errno);
  refuse_other_kinds(status, path_, target.other_kinds);
  // With O_NONBLOCK, an io_uring request would fail with EAGAIN instead of waiting for the disk.
  if (const int found = ::fcntl(opened.descriptor_, F_GETFL);
      found < 0 || ::fcntl(opened.descriptor_, F_SETFL, found & ~O_NONBLOCK) < 0)
    throw system_error("open", path_.native(), errno);
  std::swap(descriptor_, opened.descriptor_);
}

File::~File() {
  if (descriptor_ < 0) return;
  release_lock(descriptor_);
  ::close(descriptor_);
}

File::File(File&& other) noexcept
    : path_(std::move(other.path_)), descriptor_(std::exchange(other.descriptor_, -1)) {}

File& File::operator=(File&& other) noexcept {
  std::swap(path_, other.path_);
  std::swap(descriptor_, other.descriptor_);
  return *this;
}

void File::read_at(std::uint64_t offset, std::span<std::byte> into) const {
  while (!into.empty()) {
    const std::uint64_t got = read_some(offset, std::span(&into, 1));
    into = into.subspan(got);
    offset += got;
  }
}

void File::write_at(std::uint64_t offset, std::span<const std::byte> from) {
  while (!from.empty()) {
    // The cast is safe: a write does not change the memory.
    const std::span<std::byte> rest(const_cast<std::byte*>(from.data()), from.size());
    const std::uint64_t put = write_some(offset, std::span(&rest, 1));
    from = from.subspan(put);
    offset += put;
  }
}

std::uint64_t File::read_some(std::uint64_t offset,
                              std::span<const std::span<std::byte>> pieces) const {
  Pieces vectors(pieces);
  const ssize_t got =
      attempt({Kind::kRead, path_, offset, vectors.bytes()}, [&](std::uint64_t most_bytes) {
        const std::span<const iovec> part = vectors.first(most_bytes);
        return ::preadv(descriptor_, part.data(), static_cast<int>(part.size()),
                        static_cast<off_t>(offset));
      });
  if (got < 0) throw system_error("read", path_.native(), errno, offset);
  if (got == 0)
    throw Error(ErrorCode::kCorruption,
                fmt::format("read {}: the file ends at byte {}, expected {} more bytes there",
                            path_.native(), offset, pieces.front().size()))
        .about(path_, offset);
  return static_cast<std::uint64_t>(got);
}

std::uint64_t File::write_some(std::uint64_t offset, std::span<const std::span<std::byte>> pieces) {
  Pieces vectors(pieces);
  const ssize_t put =
      attempt({Kind::kWrite, path_, offset, vectors.bytes()}, [&](std::uint64_t most_bytes) {
        const std::span<const iovec> part = vectors.first(most_bytes);
        return ::pwritev(descriptor_, part.data(), static_cast<int>(part.size()),
                         static_cast<off_t>(offset));
      });
  if (put < 0) throw system_error("write", path_.native(), errno, offset);
  if (put == 0)
    throw Error(ErrorCode::kIo, fmt::format("write {}: at byte {} none of {} bytes was written",
                                            path_.native(), offset, pieces.front().size()))
        .about(path_, offset);
  return static_cast<std::uint64_t>(put);
}

std::uint64_t File::size() const {
  struct stat status {};
  if (::fstat(descriptor_, &status) != 0) throw system_error("stat", path_.native(), errno);
  return static_cast<std::uint64_t>(status.st_size);
}

void File::resize(std::uint64_t bytes) {
  if (attempt({Kind::kResize, path_, 0, bytes},
              [&](auto) { return ::ftruncate(descriptor_, static_cast<off_t>(bytes)); }) < 0)
    throw system_error("resize", path_.native(), errno);
}

void File::preallocate(std::uint64_t bytes) {
  // An interrupted call on tmpfs gives back all that it has allocated. So the pieces get smaller
  // until one fits between two signals.
  constexpr std::uint64_t kLeastPiece = std::uint64_t{1} << 16;
  constexpr int kMostInterruptions = 1000;
  std::uint64_t piece = bytes;
  int interruptions = 0;
  for (std::uint64_t done = 0; done < bytes;) {
    const std::uint64_t count = std::min(piece, bytes - done);
    const ssize_t result = attempt_once({Kind::kPreallocate, path_, done, count}, [&](auto) {
      errno = ::posix_fallocate(descriptor_, static_cast<off_t>(done), static_cast<off_t>(count));
      return errno == 0 ? 0 : -1;
    });
    if (result >= 0) {
      done += count;
      interruptions = 0;
    } else if (errno == EINTR && ++interruptions < kMostInterruptions) {
      piece = std::max(kLeastPiece, piece / 2);
    } else if (errno == EOPNOTSUPP || errno == EINVAL || errno == ENOSYS || errno == EPERM ||
               errno == EINTR) {
      // The file system cannot allocate, a filter of system calls forbids it, or no piece fits
      // between two signals: a full disk is then an error of a later write.
      return;
    } else {
      throw system_error("preallocate", path_.native(), errno);
    }
  }
}

void File::sync() {
  if (attempt({Kind::kSync, path_}, [&](auto) { return ::fdatasync(descriptor_); }) < 0)
    throw system_error("sync", path_.native(), errno);
}

bool File::lock(bool exclusive) { return take_lock(descriptor_, exclusive, path_); }

void File::close() {
  if (descriptor_ < 0) return;
  const int verdict = before_operation({Kind::kClose, path_}).error;
  release_lock(descriptor_);
  const int result = ::close(std::exchange(descriptor_, -1));
  // On Linux the descriptor is closed even after EINTR.
  const int error = verdict != 0 ? verdict : result != 0 ? errno : 0;
  if (error != 0 && error != EINTR) throw system_error("close", path_.native(), error);
}

std::optional<File> open_if_present(const Directory& directory, const std::string& name,
                                    OpenMode mode) {
  try {
    return File(directory, name, mode);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kNotFound) throw;
    return std::nullopt;
  }
}

PLAIT_END_NAMESPACE
