#include "store/lock.h"

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <string>
#include <thread>

#include "format/file_names.h"
#include "format/manifest.h"
#include "io/locks.h"
#include "io/process.h"
#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr int kLockAttempts = 1000;

std::string holder_text(const File& file) {
  char text[32] = {};
  const ssize_t got = ::pread(file.descriptor(), text, sizeof(text) - 1, 0);
  if (got <= 0) return "another process";
  const std::string process(text, strnlen(text, sizeof(text)));
  return process == std::to_string(::getpid()) ? "this process" : "process " + process;
}

/// The names of the file beside `lock`: a lock that somebody made a hard link of his own file.
std::uint64_t other_names(const File& file) {
  struct stat status {};
  if (::fstat(file.descriptor(), &status) != 0)
    throw system_error("stat", file.path().native(), errno);
  return status.st_nlink > 1 ? status.st_nlink - 1 : 0;
}

std::string hard_links_text(std::uint64_t other) {
  return fmt::format("expected a file with one name, found one with {} other{} (hard links)", other,
                     other == 1 ? "" : "s");
}

}  // namespace

File open_to_exclude(const Directory& store, const std::string& name) {
  try {
    return {store, name, OpenMode::kReadWrite};
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kIo) throw;
    return {store, name, OpenMode::kRead};
  }
}

namespace {

/// For a writer, who writes into the file.
File open_to_write(const Directory& store) {
  for (int attempt = 0; attempt < kLockAttempts; ++attempt) {
    if (std::optional<File> file = open_if_present(store, kLockName, OpenMode::kReadWrite)) {
      if (const std::uint64_t other = other_names(*file); other > 0)
        throw Error(ErrorCode::kCorruption,
                    fmt::format("open {}: {}; plait repair makes a new one", file->path().native(),
                                hard_links_text(other)))
            .about(file->path());
      return std::move(*file);
    }
    std::optional<File> made;
    try {
      made = File(store, kLockName, OpenMode::kCreate);
    } catch (const Error&) {
      if (!store.contains(kLockName)) throw;
      continue;  // another writer was faster
    }
    if (has_whole_slot(store)) return std::move(*made);
    store.remove_if_possible(kLockName);
    throw Error(ErrorCode::kNotFound, fmt::format("open {}: expected a store, found a directory "
                                                  "without the {} of one",
                                                  store.path().native(), kManifestName));
  }
  throw Error(ErrorCode::kBusy, fmt::format("open {}: other processes make and remove it",
                                            store.path_of(kLockName).native()));
}

File open_for(const Directory& store, LockFor purpose) {
  switch (purpose) {
    case LockFor::kReading:
    case LockFor::kMaintaining:
      break;
    case LockFor::kWriting:
      return open_to_write(store);
    case LockFor::kCreating:
      return {store, kLockName, OpenMode::kCreate};
  }
  return purpose == LockFor::kMaintaining ? open_to_exclude(store, kLockName)
                                          : File(store, kLockName, OpenMode::kRead);
}

}  // namespace

StoreLock::StoreLock(const Directory& store, LockFor purpose) : file_(open_for(store, purpose)) {
  try {
    take(store, purpose != LockFor::kReading);
  } catch (...) {
    if (purpose == LockFor::kCreating) store.remove_if_possible(kLockName);
    throw;
  }
}

void StoreLock::take(const Directory& store, bool alone) {
  for (int attempt = 0; attempt < kLockAttempts; ++attempt) {
    const LockResult result = try_lock(file_, alone);
    if (result != LockResult::kConflict) {
      protects_ = result == LockResult::kTaken;
      if (protects_) keep_lock_from_children(file_.descriptor());
      return check_name(store);
    }
    if (!alone || try_lock(file_, false) == LockResult::kConflict) break;
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

std::optional<std::string> missing_protection(const StoreLock& lock, const Directory& store) {
  if (!lock.protects())
    return fmt::format(
        "{}: its file system has no locks (flock): nothing keeps a second writer out, and files of "
        "old versions stay, because a reader may need them",
        store.path().native());
  if (!locks_are_seen_by_all(store.descriptor()))
    return fmt::format(
        "{}: another machine may not see the locks of its file system: write it from one machine "
        "at a time; files of old versions stay, because a reader may need them",
        store.path().native());
  return std::nullopt;
}

std::optional<std::string> why_unusable_lock(const Directory& store) {
  try {
    const File file(store, kLockName, OpenMode::kRead);
    if (const std::uint64_t other = other_names(file); other > 0)
      return fmt::format("{}: {}", file.path().native(), hard_links_text(other));
    return std::nullopt;
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kNotFound && error.code() != ErrorCode::kCorruption) throw;
    return error.what();
  }
}

void make_lock_anew(const Directory& store) {
  std::optional<File> held;
  try {
    held = open_to_exclude(store, kLockName);
  } catch (const Error& error) {
    // Nothing, or no file, is there, so nobody has locked it.
    if (error.code() != ErrorCode::kCorruption && error.code() != ErrorCode::kNotFound) throw;
  }
  if (held && try_lock(*held, true) == LockResult::kConflict)
    throw Error(ErrorCode::kBusy,
                fmt::format("replace {}: another process has locked it", held->path().native()));
  if (!store.remove_directory(kLockName)) store.remove(kLockName);
  File(store, kLockName, OpenMode::kCreate).close();
}

PLAIT_END_NAMESPACE
