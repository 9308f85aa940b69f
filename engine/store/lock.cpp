#include "store/lock.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstring>
#include <string>

#include "plait/error.h"
#include "store/file_names.h"

namespace plait {
namespace {

std::string holder_text(const File& file) {
  char text[32] = {};
  const ssize_t got = ::pread(file.descriptor(), text, sizeof(text) - 1, 0);
  return got > 0 ? fmt::format("process {}", std::string(text, strnlen(text, sizeof(text))))
                 : std::string("another process");
}

OpenMode mode_for(LockFor purpose) {
  switch (purpose) {
    case LockFor::kReading:
    case LockFor::kRecovering:
      return OpenMode::kRead;
    case LockFor::kWriting:
      return OpenMode::kReadWrite;
    case LockFor::kCreating:
      return OpenMode::kCreate;
  }
  return OpenMode::kRead;
}

}  // namespace

StoreLock::StoreLock(const Directory& store, LockFor purpose)
    : file_(store, kLockName, mode_for(purpose)) {
  try {
    take(store, purpose != LockFor::kReading);
  } catch (...) {
    if (purpose == LockFor::kCreating) store.remove_if_possible(kLockName);
    throw;
  }
}

void StoreLock::take(const Directory& store, bool alone) {
  if (file_.lock(alone)) return check_name(store);
  const std::string& path = file_.path().native();
  // Readers leave no name, and do not keep another one out.
  if (alone && file_.lock(false))
    throw Error(ErrorCode::kBusy, fmt::format("open {} for writing: in use by readers", path));
  throw Error(ErrorCode::kBusy,
              fmt::format("open {}: in use by {}, which writes it", path, holder_text(file_)));
}

/// Between opening and locking somebody may have removed the store.
void StoreLock::check_name(const Directory& store) const {
  struct stat held {
  }, named{};
  if (::fstat(file_.descriptor(), &held) == 0 &&
      ::fstatat(store.descriptor(), kLockName, &named, AT_SYMLINK_NOFOLLOW) == 0 &&
      held.st_dev == named.st_dev && held.st_ino == named.st_ino)
    return;
  throw Error(ErrorCode::kBusy, fmt::format("open {}: the store is being replaced or removed",
                                            file_.path().native()));
}

void StoreLock::sign() {
  const std::string text = std::to_string(::getpid());
  file_.resize(0);
  file_.write_at(0, std::as_bytes(std::span(text)));
}

}  // namespace plait
