// Which versions of a store are read. A reader holds a shared lock (flock) on the file version.S of
// its version, for as long as it has the store open; the lock ends with its process, however that
// ends. A writer asks by trying an exclusive lock, and waits for nobody.
//
// Why no reader can be overlooked: a reader locks version.S first and reads the manifest again
// after that; a writer writes the manifest's next slot first and tries the lock after that. So a
// reader whose lock came too late for the writer to see finds the next version in the manifest, and
// starts over.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "plait/directory.h"
#include "plait/file.h"
#include "store/manifest.h"

namespace plait {

/// A version and its file version.S, which may hold a lock.
struct OpenVersion {
  Manifest manifest;
  File file;
};

/// The newest version, without a lock: for who has the writer's lock.
OpenVersion open_newest_version(const Directory& store);

/// The newest version, locked as a reader does it. Nothing if another version was committed on the
/// way, or somebody held the lock for a moment: try again. Errors: those of read_manifest; kBusy,
/// naming the process, while a writer overwrites in place or the store is replaced; kIo.
std::optional<OpenVersion> share_newest_version(const Directory& store);

/// Older versions than `newest` that readers have open, ascending. Errors: kIo.
std::vector<std::uint64_t> versions_being_read(const Directory& store, std::uint64_t newest);

/// Locks every version that has a file: readers stay out as long as the files are open. Errors:
/// kBusy if readers have a version open; kIo. REQUIRES: the writer's lock.
std::vector<File> keep_all_readers_out(const Directory& store);

/// The file of version `newest`, locked likewise. A reader opens no older version, so this one lock
/// is enough. Errors: those of keep_all_readers_out, kNotFound.
File keep_readers_out(const Directory& store, std::uint64_t newest);

/// A version that is not the newest one, as its file stands there. Errors: kNotFound, kIo.
OpenVersion open_older_version(const Directory& store, const StoreUuid& uuid,
                               std::uint64_t sequence);

}  // namespace plait
