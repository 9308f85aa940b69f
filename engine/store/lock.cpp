#include "store/lock.h"

#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>

#include "plait/error.h"

namespace plait {
namespace {

std::string holder_text(const File& file) {
  char text[32] = {};
  const ssize_t got = ::pread(file.descriptor(), text, sizeof(text) - 1, 0);
  return got > 0 ? fmt::format("process {}", std::string(text, strnlen(text, sizeof(text))))
                 : std::string("another process");
}

}  // namespace

StoreLock::StoreLock(const std::filesystem::path& path, bool exclusive, bool create)
    : file_(path, create      ? OpenMode::kCreate
                  : exclusive ? OpenMode::kReadWrite
                              : OpenMode::kRead) {
  int result = 0;
  do result = ::flock(file_.descriptor(), (exclusive ? LOCK_EX : LOCK_SH) | LOCK_NB);
  while (result != 0 && errno == EINTR);
  if (result != 0) {
    if (errno != EWOULDBLOCK) throw system_error("lock", path.native(), errno);
    throw Error(
        ErrorCode::kBusy,
        exclusive ? fmt::format("open {} for writing: in use by readers or by writer {}",
                                path.native(), holder_text(file_))
                  : fmt::format("open {}: being written by {}", path.native(), holder_text(file_)));
  }
  if (exclusive) {
    const std::string text = std::to_string(::getpid());
    file_.resize(0);
    file_.write_at(0, std::as_bytes(std::span(text)));
  }
}

}  // namespace plait
