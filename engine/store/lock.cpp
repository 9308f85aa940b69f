#include "store/lock.h"

#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <cstring>
#include <string>
#include <thread>

#include "plait/error.h"
#include "store/file_names.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr int kLockAttempts = 1000;

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
  for (int attempt = 0; attempt < kLockAttempts; ++attempt) {
    if (file_.lock(alone)) return check_name(store);
    if (!alone || !file_.lock(false)) break;
    // The lock is shared only by processes that check whether there is a writer. They release it at
    // once.
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  throw Error(ErrorCode::kBusy, fmt::format("open {}: in use by {}, which writes it",
                                            file_.path().native(), holder_text(file_)));
}

/// Another process may have removed the store after this one opened the file and before it got the
/// lock.
void StoreLock::check_name(const Directory& store) const {
  if (store.contains(kLockName, file_.descriptor())) return;
  throw Error(ErrorCode::kBusy, fmt::format("open {}: the store is being replaced or removed",
                                            file_.path().native()));
}

void StoreLock::sign() {
  const std::string text = std::to_string(::getpid());
  file_.resize(0);
  file_.write_at(0, std::as_bytes(std::span(text)));
}

PLAIT_END_NAMESPACE
