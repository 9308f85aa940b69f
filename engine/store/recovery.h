// Opening a store that its last writer may have left in the middle of something.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "plait/directory.h"
#include "plait/options.h"
#include "store/lock.h"
#include "store/version_locks.h"

namespace plait {

/// Errors: kNotFound where there is no directory.
Directory open_store_directory(const std::filesystem::path& path);

/// The last committed version, locked as long as its file is open, and in place: if blocks that
/// were overwritten without a commit have to be put back, this does it, under the writer's lock.
/// Waits for nobody but others who put blocks back. Errors: kBusy while a writer overwrites in
/// place or the store is being made or replaced; kNotFound, kCorruption, kNotSupported, kIo.
OpenVersion open_for_reading(const Directory& store);

/// The writer's lock, with the last committed version in place, as above. With kCommit the newest
/// manifest slot is on the disk when it returns. What no version that is in use names is gone. A
/// directory without a manifest is left as it is.
/// Errors: kBusy, kNotFound, kCorruption, kNotSupported, kIo.
StoreLock lock_for_writing(const Directory& store, Durability durability);

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

/// Removes, as far as possible, files that neither the newest version nor one that readers have
/// open needs; description and base records of the version before the newest stay too. Returns the
/// older versions that readers have open, ascending. REQUIRES: the writer's lock. Errors: kIo;
/// kNotFound, kCorruption, kNotSupported of the newest version.
std::vector<std::uint64_t> remove_old_versions(const Directory& store);

}  // namespace plait
