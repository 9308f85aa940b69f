// Tells which versions of a store readers have open. A reader has a shared lock (flock) on the file
// version.S of its version while it has the store open. The lock ends when its process ends, for
// any reason. A writer tests the lock by trying an exclusive one, and does not wait.
// A writer cannot overlook a reader: a reader first locks version.S and then reads the manifest
// again. A writer first writes the next slot of the manifest and then tries the lock. So if a
// reader locks too late for the writer to notice, it finds the next version in the manifest, and
// starts again.
// Where the file system has no locks, or may have locks that another machine does not see, nobody
// knows who reads. Then every version counts as being read, and keeps its files.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "format/manifest.h"
#include "plait/extend/directory.h"
#include "plait/extend/file.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// A version and its open file version.S, which may have a lock.
struct OpenVersion {
  Manifest manifest;
  File file;
  bool is_newest = true;  ///< else the manifest has no checksum of the file
};

/// Opens the newest version without a lock. For processes that have the writer's lock.
OpenVersion open_newest_version(const Directory& store);

/// Opens the newest version and locks it as a reader does. Returns nothing if another version was
/// committed meanwhile, or if another process had the lock for a moment; the caller then tries
/// again. Errors: those of read_manifest; kBusy (the message names the process) while the store is
/// replaced; kIo.
std::optional<OpenVersion> share_newest_version(const Directory& store);

/// The versions with a file, older than `newest`, that readers may have open, ascending. A reader
/// of a small commit has the version open whose file describes it. Errors: kIo.
std::vector<std::uint64_t> versions_being_read(const Directory& store, std::uint64_t newest);

/// Locks every version that has a file. No reader can open the store while the caller has the
/// returned files open. Errors: kBusy if readers have a version open; kIo. REQUIRES: the writer's
/// lock.
std::vector<File> keep_all_readers_out(const Directory& store);

/// Opens a version with a file that is not the newest one. The size is that of the file itself.
/// `features_of_all`: required features that all versions of the store have. Errors: kNotFound,
/// kIo.
OpenVersion open_older_version(const Directory& store, const StoreUuid& uuid,
                               std::uint64_t sequence, std::uint32_t features_of_all = 0);

PLAIT_END_NAMESPACE
