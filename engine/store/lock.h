// The lock of a store: who changes it has it alone. Readers lock their version (version_locks.h).
#pragma once

#include <cstdint>
#include <utility>

#include "plait/directory.h"
#include "plait/file.h"

namespace plait {

enum class LockFor : std::uint8_t {
  kReading,  ///< to learn whether a writer has it: readers of a version need no lock of the store
  kRecovering,  ///< alone, and without a word in the file: by a reader too
  kWriting,     ///< alone
  kCreating,    ///< as kWriting, of a store that has no lock file yet
};

/// Holds the store's lock until destroyed. It is a lock of the open file (flock), so that it also
/// tells two opens of one process apart and ends with its holder, however that ends; the record
/// locks behind Boost.Interprocess file_lock do neither.
class StoreLock {
 public:
  StoreLock() = default;
  /// Changes nothing in a file that is there. Errors: kBusy, of a writer with its process number;
  /// kCorruption if the lock is no regular file; kIo.
  StoreLock(const Directory& store, LockFor purpose);

  /// Leaves this process's number in the file, for those who find it taken. REQUIRES: the purpose
  /// is kWriting or kCreating, and the directory is known to be a store. Errors: kIo, kNoSpace.
  void sign();
  /// Whoever has the file has the lock.
  File release() && { return std::move(file_); }

 private:
  void take(const Directory& store, bool alone);
  void check_name(const Directory& store) const;

  File file_;
};

}  // namespace plait
