// The lock of a store. A process that changes the store has the lock exclusively. Readers lock
// their version (version_locks.h).
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include "plait/extend/directory.h"
#include "plait/extend/file.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

enum class LockFor : std::uint8_t {
  kReading,  ///< shared, to check whether there is a writer; readers of a version need no such lock
  kMaintaining,  ///< exclusive, without a process number in the file; also for readers
  kWriting,      ///< exclusive; makes the lock file of a store that has lost it
  kCreating,     ///< as kWriting, for a store that has no lock file yet
};

/// Holds the store's lock until it is destroyed. It is a lock of the open file (flock). So two
/// opens in one process conflict too, and the lock ends when its process ends, for any reason. (The
/// record locks of Boost.Interprocess file_lock do neither.)
class StoreLock {
 public:
  StoreLock() = default;
  /// Does not change the content of an existing lock file. Errors: kBusy (the message names a
  /// writer's process number); kCorruption if the lock file is not a regular file, or, for writing,
  /// if it has another name too and so may be somebody else's; kIo.
  StoreLock(const Directory& store, LockFor purpose);

  /// Throws if the lock file has lost its name: then other writers do not see this lock. Errors:
  /// kBusy, kIo.
  void check_name(const Directory& store) const;

  /// False if the file system has no locks: then other processes are not kept out.
  bool protects() const noexcept { return protects_; }
  /// Writes the number of this process to the file, for the messages of other processes. REQUIRES:
  /// the purpose is kWriting or kCreating, and the directory is known to be a store. Errors: kIo,
  /// kNoSpace.
  void sign();
  /// The caller then has the lock while it has the file open.
  File release() && { return std::move(file_); }

 private:
  void take(const Directory& store, bool alone);

  File file_;
  bool protects_ = false;
};

/// What the lock of a writer does not protect, because the file system has no locks or may have
/// some that another machine does not see: a line for the user. Nothing if it protects.
std::optional<std::string> missing_protection(const StoreLock& lock, const Directory& store);

/// Opens the file `name` of the store for an exclusive lock: for writing, because NFS locks no
/// other file exclusively; for reading if the file may not be written. Errors: as File's
/// constructor.
File open_to_exclude(const Directory& store, const std::string& name);

/// Why no writer can use the store's lock file, which repair then makes anew; nothing if one can.
/// Errors: kIo.
std::optional<std::string> why_unusable_lock(const Directory& store);

/// Replaces a lock file that no writer can use by a new one. Errors: kBusy if another process has
/// locked it; kIo, kNoSpace.
void make_lock_anew(const Directory& store);

PLAIT_END_NAMESPACE
