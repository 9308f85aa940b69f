#include "plait/file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <utility>

#include "plait/error.h"
#include "plait/file_operations.h"

namespace plait {
namespace {

using Kind = FileOperation::Kind;

int flags_of(OpenMode mode) {
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

/// Linux moves at most this much in one call.
constexpr std::uint64_t kMaxTransferBytes = 0x7ffff000;

/// Makes a system call, again if it was interrupted. `call(most_bytes)` returns what such calls do:
/// -1 and errno, or a value. Returns -1 and errno likewise.
template <class Call>
ssize_t attempt(FileOperation operation, Call call) noexcept {
  while (true) {
    const FileOperationHook::Verdict verdict = before_operation(operation);
    errno = verdict.error;
    ssize_t result = verdict.error != 0 ? -1 : 0;
    if (result == 0 && !verdict.pretend)
      result = call(std::min({verdict.most_bytes, operation.bytes, kMaxTransferBytes}));
    if (result < 0 && errno == EINTR) continue;
    if (result >= 0) {
      if (operation.kind == Kind::kRead || operation.kind == Kind::kWrite)
        operation.bytes = static_cast<std::uint64_t>(result);
      after_operation(operation);
    }
    return result;
  }
}

}  // namespace

File::File(const std::filesystem::path& path, OpenMode mode, Caching caching) : path_(path) {
  const int flags = flags_of(mode) | O_CLOEXEC | (caching == Caching::kNone ? O_DIRECT : 0);
  const FileOperation operation{mode == OpenMode::kCreate ? Kind::kCreate : Kind::kOpen, path_};
  descriptor_ =
      static_cast<int>(attempt(operation, [&](auto) { return ::open(path.c_str(), flags, 0644); }));
  if (descriptor_ < 0 && errno == EINVAL && caching == Caching::kNone)
    throw Error(ErrorCode::kNotSupported,
                fmt::format("open {}: its file system has no O_DIRECT", path.native()));
  if (descriptor_ < 0)
    throw system_error(mode == OpenMode::kCreate ? "create" : "open", path.native(), errno);
}

File::~File() {
  if (descriptor_ >= 0) ::close(descriptor_);
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
    const ssize_t got = attempt({Kind::kRead, path_, offset, into.size()}, [&](auto most_bytes) {
      return ::pread(descriptor_, into.data(), most_bytes, static_cast<off_t>(offset));
    });
    if (got < 0) throw system_error("read", path_.native(), errno);
    if (got == 0)
      throw Error(ErrorCode::kCorruption,
                  fmt::format("read {}: the file ends at byte {}, expected {} more bytes there",
                              path_.native(), offset, into.size()));
    into = into.subspan(static_cast<std::size_t>(got));
    offset += static_cast<std::uint64_t>(got);
  }
}

void File::write_at(std::uint64_t offset, std::span<const std::byte> from) {
  while (!from.empty()) {
    const ssize_t put = attempt({Kind::kWrite, path_, offset, from.size()}, [&](auto most_bytes) {
      return ::pwrite(descriptor_, from.data(), most_bytes, static_cast<off_t>(offset));
    });
    if (put < 0) throw system_error("write", path_.native(), errno);
    if (put == 0)
      throw Error(ErrorCode::kIo, fmt::format("write {}: at byte {} none of {} bytes was taken",
                                              path_.native(), offset, from.size()));
    from = from.subspan(static_cast<std::size_t>(put));
    offset += static_cast<std::uint64_t>(put);
  }
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
  if (bytes == 0) return;
  if (attempt({Kind::kPreallocate, path_, 0, bytes}, [&](auto) {
        errno = ::posix_fallocate(descriptor_, 0, static_cast<off_t>(bytes));
        return errno == 0 ? 0 : -1;
      }) < 0)
    throw system_error("preallocate", path_.native(), errno);
}

void File::sync() {
  if (attempt({Kind::kSync, path_}, [&](auto) { return ::fdatasync(descriptor_); }) < 0)
    throw system_error("sync", path_.native(), errno);
}

bool File::lock(bool exclusive) {
  const int operation = (exclusive ? LOCK_EX : LOCK_SH) | LOCK_NB;
  if (attempt({Kind::kLock, path_}, [&](auto) { return ::flock(descriptor_, operation); }) >= 0)
    return true;
  if (errno == EWOULDBLOCK) return false;
  throw system_error("lock", path_.native(), errno);
}

void File::close() {
  if (descriptor_ < 0) return;
  const int verdict = before_operation({Kind::kClose, path_}).error;
  const int result = ::close(std::exchange(descriptor_, -1));
  // On Linux the descriptor is gone even after EINTR.
  const int error = verdict != 0 ? verdict : result != 0 ? errno : 0;
  if (error != 0 && error != EINTR) throw system_error("close", path_.native(), error);
}

void make_directory(const std::filesystem::path& path) {
  if (attempt({Kind::kMakeDirectory, path}, [&](auto) { return ::mkdir(path.c_str(), 0777); }) < 0)
    throw system_error("create", path.native(), errno);
}

void remove_file(const std::filesystem::path& path) {
  if (attempt({Kind::kRemove, path}, [&](auto) { return ::unlink(path.c_str()); }) < 0 &&
      errno != ENOENT)
    throw system_error("remove", path.native(), errno);
}

void remove_file_if_possible(const std::filesystem::path& path) noexcept {
  attempt({Kind::kRemove, path}, [&](auto) { return ::unlink(path.c_str()); });
}

void sync_directory(const std::filesystem::path& directory) {
  const int descriptor = ::open(directory.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) throw system_error("open", directory.native(), errno);
  const ssize_t result =
      attempt({Kind::kSyncDirectory, directory}, [&](auto) { return ::fsync(descriptor); });
  const int sync_errno = errno;
  ::close(descriptor);
  if (result < 0) throw system_error("sync", directory.native(), sync_errno);
}

}  // namespace plait
