// Makes a store of the shards that many machines have made.
#pragma once

#include <cstddef>
#include <vector>

#include "format/version_description.h"
#include "plait/extend/block_table.h"
#include "plait/extend/directory.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Commits version 1 of a store in shards, in a directory that claim_store_directory() gave and
/// that has base.mesh and all files of the shards. `base_records` are those of all base vertices,
/// for each attribute; the function enters their checksums in the description. All is synced.
/// Errors: kIo, kNoSpace.
void commit_joined_store(const Directory& store, const StoreUuid& uuid,
                         VersionDescription description,
                         const std::vector<std::vector<std::byte>>& base_records);

PLAIT_END_NAMESPACE
