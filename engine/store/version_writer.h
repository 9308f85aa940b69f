// Writes the files of a version of a store, and makes it the newest one (docs/durability.md).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "format/manifest.h"
#include "format/version_description.h"
#include "plait/extend/block_table.h"
#include "plait/extend/directory.h"
#include "plait/extend/file.h"
#include "plait/extend/vector3.h"
#include "store/lock.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// What a version has beside the base mesh and the files of its levels.
struct VersionContent {
  VersionDescription description;  ///< publish_version() enters sizes and checksums of the records
  /// Of all base vertices, for each attribute; of all base faces, for each face attribute.
  std::vector<std::span<const std::byte>> base_records, face_records;
  /// [attribute] the file that has its base records instead, or nullptr. Empty: none has.
  std::vector<const File*> base_files = {};
  /// Of the base mesh, for a store whose base records are packed (format/base_records_file.h).
  std::optional<std::span<const Vector3<double>>> positions = {};
  std::vector<const BlockTable*> tables = {};  ///< of all levels; none if they are in shards
  LogPlace log = {};                           ///< the change log that the tables name
};

/// Publishes version `sequence`, with files of its own, and returns what the manifest says of it.
/// `lock` is that of a writer. If `durable`, all is synced. REQUIRES: the files of the levels and
/// the log are complete, and synced if `durable`. Errors: kBusy, kIo, kNoSpace.
Manifest publish_version(const Directory& store, const StoreLock& lock, const StoreUuid& uuid,
                         std::uint64_t sequence, VersionContent content, bool durable);

/// Publishes a version whose changes are in the log. REQUIRES: the log is synced if `durable`.
/// Errors: kBusy, kIo, kNoSpace.
void publish_changes(const Directory& store, const StoreLock& lock, const Manifest& version,
                     bool durable);

PLAIT_END_NAMESPACE
