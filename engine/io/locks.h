// io/locks.h: locks of open files (flock), on file systems that have them and on others.
//
// NFS without lockd answers ENOLCK, Lustre without "-o flock" ENOSYS, some FUSE file systems
// EOPNOTSUPP, DVS 524, a filter of system calls EPERM. File systems of networks may have locks that
// only one machine sees.
#pragma once

#include <cstdint>
#include <filesystem>

#include "plait/detail/namespace.h"
#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Takes a lock as File::lock and Directory::lock do. Errors: kNotSupported if the file system has
/// no locks of this kind; kIo. Both name `path`.
bool take_lock(int descriptor, bool exclusive, const std::filesystem::path& path);

/// What came of an attempt to take a lock.
enum class LockResult : std::uint8_t {
  kTaken,
  kConflict,  ///< another open file has a lock that excludes it
  kNoLocks,   ///< the file system has no locks, so nobody has one
};

/// Tries to lock a File or a Directory. Does not wait. On NFS, only a file that is open for writing
/// can have an exclusive lock. Errors: kIo.
template <class Opened>
LockResult try_lock(Opened& opened, bool exclusive) {
  try {
    return opened.lock(exclusive) ? LockResult::kTaken : LockResult::kConflict;
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kNotSupported) throw;
    return LockResult::kNoLocks;
  }
}

/// Whether all processes that can have a file open see its locks: the file system is one of a
/// single machine. False if that is not known.
bool locks_are_seen_by_all(int descriptor) noexcept;

PLAIT_END_NAMESPACE
