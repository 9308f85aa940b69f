// Opening a store that its last writer may have left in the middle of something.
#pragma once

#include <filesystem>

#include "plait/options.h"
#include "store/lock.h"
#include "store/manifest.h"

namespace plait {

/// Locks the store, for a writer or for a reader, with the last committed version in place: if an
/// overwriting that was not committed has to be undone, this does it, under the writer's lock, also
/// for readers. For a durable writer the newest manifest slot is on the disk when it returns, and
/// what no version names is gone. Errors: kBusy, kNotFound, kCorruption, kNotSupported, kIo.
StoreLock lock_recovered(const std::filesystem::path& store, bool writable, Durability durability);

/// Removes an empty directory, or a store whose writer was killed before its first commit, which
/// left the manifest blank; nothing that anybody holds or that has a file of another name.
/// Errors: kIo.
void remove_if_never_committed(const std::filesystem::path& store);

/// Removes the files of versions that neither slot of the manifest names, as far as possible.
void remove_left_over_files(const std::filesystem::path& store) noexcept;

}  // namespace plait
