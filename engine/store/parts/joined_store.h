// Commits a version of a store in shards, whose shards many machines have made.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "format/version_description.h"
#include "plait/extend/block_table.h"
#include "plait/extend/directory.h"
#include "store/lock.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Commits version `sequence`. The directory has base.mesh and all files of the shards. `lock` is
/// that of a writer. `base_records` are those of all base vertices, for each attribute; the
/// function enters their checksums in the description. `face_records` are those of each face
/// attribute. All is synced. Errors: kBusy, kIo, kNoSpace.
void commit_joined_version(const Directory& store, const StoreLock& lock, const StoreUuid& uuid,
                           std::uint64_t sequence, VersionDescription description,
                           const std::vector<std::vector<std::byte>>& base_records,
                           const std::vector<std::vector<std::byte>>& face_records = {});

PLAIT_END_NAMESPACE
