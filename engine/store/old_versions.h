// Removes files of old versions where nobody knows who reads them.
#pragma once

#include <chrono>
#include <cstdint>

#include "plait/detail/namespace.h"
#include "plait/extend/directory.h"

PLAIT_BEGIN_NAMESPACE

struct RemovedVersions {
  std::uint64_t files = 0, bytes = 0;  ///< that were removed, or would be
  std::uint64_t versions_kept = 0;     ///< older than the newest one, for their readers
};

/// Removes files of old versions as remove_old_versions() does, and also those of versions that
/// were replaced `age` ago or earlier: on a file system of a network nobody knows whether another
/// machine reads them. A version with a lock that is seen here stays. With `dry_run`, removes
/// nothing. Takes the writer's lock. Errors: kBusy; those of remove_old_versions().
RemovedVersions remove_versions_replaced_before(const Directory& store, std::chrono::seconds age,
                                                bool dry_run);

PLAIT_END_NAMESPACE
