// Opening a store that its last writer may have left in the middle of something.
#pragma once

#include <filesystem>

#include "plait/directory.h"
#include "plait/options.h"
#include "store/lock.h"
#include "store/manifest.h"

namespace plait {

/// Errors: kNotFound where there is no directory.
Directory open_store_directory(const std::filesystem::path& path);

/// Locks the store, for a writer or for a reader, with the last committed version in place: if an
/// overwriting that was not committed has to be undone, this does it, under the writer's lock, also
/// for readers. For a durable writer the newest manifest slot is on the disk when it returns, and
/// what no version names is gone. A directory without a manifest is left as it is.
/// Errors: kBusy, kNotFound, kCorruption, kNotSupported, kIo.
StoreLock lock_recovered(const Directory& store, bool writable, Durability durability);

/// A new directory, or an empty one that is there, with the manifest of a store that was begun.
/// What a writer left that was killed before its first commit goes, unless there is a file of
/// another name or somebody has it. Errors: kInvalidArgument if `path` is taken; kIo, kNoSpace.
Directory claim_store_directory(const std::filesystem::path& path, Durability durability);

/// Whether a directory is what a writer leaves that is killed before its first commit: empty, or
/// its manifest says so. Errors: kIo; kCorruption if the manifest is no regular file.
bool is_uncommitted(const Directory& store);

/// Removes a store without a commit in an order that leaves such a directory at every moment. What
/// is no file of a store stays, and then so does the directory.
void remove_uncommitted(const Directory& store) noexcept;

/// Removes the files of versions that neither slot of the manifest names, as far as possible.
void remove_left_over_files(const Directory& store) noexcept;

}  // namespace plait
