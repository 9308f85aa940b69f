// Opens a store whose last writer may have been killed at any moment.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "plait/extend/directory.h"
#include "plait/options.h"
#include "store/lock.h"
#include "store/version_locks.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Errors: kNotFound if there is no directory, or if it is not a store.
Directory open_store_directory(const std::filesystem::path& path);

/// Opens the last committed version, and locks it while its file is open. Errors: kBusy while the
/// store is being made or replaced; kNotFound, kCorruption, kNotSupported, kIo.
OpenVersion open_for_reading(const Directory& store);

/// Takes the writer's lock. With kCommit, the newest manifest slot is on the disk when the call
/// returns. Does not change a directory without a manifest. Errors: kBusy, kNotFound, kCorruption,
/// kNotSupported, kIo.
StoreLock lock_for_writing(const Directory& store, Durability durability);

/// Makes a directory, or takes an existing empty one, and creates the manifest of a new store in
/// it. First removes a store that a writer left which was killed before its first commit, unless
/// the directory has other files or another process has locked it. Errors: kInvalidArgument if
/// `path` is taken; kIo, kNoSpace.
Directory claim_store_directory(const std::filesystem::path& path, Durability durability);

/// Whether a directory is empty, or its manifest is that of a store that was never committed. A
/// writer that is killed before its first commit leaves such a directory. Errors: kIo; kCorruption
/// if the manifest is not a regular file.
bool is_uncommitted(const Directory& store);

/// Removes a store without a commit, in an order that leaves such a directory at every moment.
/// Other files stay, and then the directory stays too.
void remove_uncommitted(const Directory& store) noexcept;

/// Removes files of old versions, as far as possible. The newest version, and versions that readers
/// have open, keep theirs; the version before the newest one keeps its description and base
/// records. Returns the older versions that readers have open, in ascending order. REQUIRES: the
/// writer's lock. Errors: kIo; kNotFound, kCorruption, kNotSupported for the newest version.
std::vector<std::uint64_t> remove_old_versions(const Directory& store);

PLAIT_END_NAMESPACE
