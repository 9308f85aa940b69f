#include "plait/file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <utility>

#include "plait/error.h"

namespace plait {
namespace {

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
constexpr std::size_t kMaxTransferBytes = 0x7ffff000;

}  // namespace

File::File(const std::filesystem::path& path, OpenMode mode, Caching caching) : path_(path) {
  const int flags = flags_of(mode) | O_CLOEXEC | (caching == Caching::kNone ? O_DIRECT : 0);
  do descriptor_ = ::open(path.c_str(), flags, 0644);
  while (descriptor_ < 0 && errno == EINTR);
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
    const ssize_t got = ::pread(descriptor_, into.data(), std::min(into.size(), kMaxTransferBytes),
                                static_cast<off_t>(offset));
    if (got < 0) {
      if (errno == EINTR) continue;
      throw system_error("read", path_.native(), errno);
    }
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
    const ssize_t put = ::pwrite(descriptor_, from.data(), std::min(from.size(), kMaxTransferBytes),
                                 static_cast<off_t>(offset));
    if (put < 0) {
      if (errno == EINTR) continue;
      throw system_error("write", path_.native(), errno);
    }
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
  int result = 0;
  do result = ::ftruncate(descriptor_, static_cast<off_t>(bytes));
  while (result != 0 && errno == EINTR);
  if (result != 0) throw system_error("resize", path_.native(), errno);
}

void File::preallocate(std::uint64_t bytes) {
  if (bytes == 0) return;
  int result = 0;
  do result = ::posix_fallocate(descriptor_, 0, static_cast<off_t>(bytes));
  while (result == EINTR);
  if (result != 0) throw system_error("preallocate", path_.native(), result);
}

void File::sync() {
  if (::fdatasync(descriptor_) != 0) throw system_error("sync", path_.native(), errno);
}

void File::close() {
  if (descriptor_ < 0) return;
  const int result = ::close(std::exchange(descriptor_, -1));
  // On Linux the descriptor is gone even after EINTR.
  if (result != 0 && errno != EINTR) throw system_error("close", path_.native(), errno);
}

void sync_directory(const std::filesystem::path& directory) {
  const int descriptor = ::open(directory.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) throw system_error("open", directory.native(), errno);
  const int result = ::fsync(descriptor);
  const int sync_errno = errno;
  ::close(descriptor);
  if (result != 0) throw system_error("sync", directory.native(), sync_errno);
}

}  // namespace plait
