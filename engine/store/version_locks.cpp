#include "store/version_locks.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <utility>

#include "format/file_names.h"
#include "io/locks.h"
#include "io/process.h"
#include "plait/error.h"
#include "store/lock.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// Whether the manifest now names another version file than `from`, or none. Small commits that
/// follow change no byte that `from` needs, and remove no file.
bool has_moved_on(const Directory& store, const Manifest& from) {
  try {
    const Manifest now = read_manifest(store);
    return now.uuid != from.uuid || now.described != from.described ||
           now.version_checksum != from.version_checksum;
  } catch (const Error& error) {
    if (error.code() == ErrorCode::kNotFound || error.code() == ErrorCode::kCorruption) return true;
    throw;
  }
}

/// The versions that have a file, ascending.
std::vector<std::uint64_t> versions_there(const Directory& store) {
  std::vector<std::uint64_t> versions;
  for (const std::string& name : store.names())
    if (const auto version = version_described_by(name)) versions.push_back(*version);
  std::ranges::sort(versions);
  return versions;
}

/// Whether a reader may have the version open. If its file is not a regular file, no reader has.
bool is_being_read(const Directory& store, std::uint64_t version) {
  try {
    File file = open_to_exclude(store, version_file_name(version));
    return try_lock(file, true) != LockResult::kTaken || !locks_are_seen_by_all(file.descriptor());
  } catch (const Error& error) {
    if (error.code() == ErrorCode::kNotFound || error.code() == ErrorCode::kCorruption)
      return false;
    throw;
  }
}

}  // namespace

OpenVersion open_newest_version(const Directory& store) {
  const Manifest manifest = read_manifest(store);
  return {manifest, File(store, version_file_name(manifest.described), OpenMode::kRead)};
}

std::optional<OpenVersion> share_newest_version(const Directory& store) {
  OpenVersion version;
  version.manifest = read_manifest(store);
  const std::string name = version_file_name(version.manifest.described);
  try {
    version.file = File(store, name, OpenMode::kRead);
  } catch (const Error& error) {
    if (error.code() == ErrorCode::kNotFound && has_moved_on(store, version.manifest)) return {};
    throw;
  }
  const LockResult lock = try_lock(version.file, false);
  if (lock == LockResult::kTaken) keep_lock_from_children(version.file.descriptor());
  if (has_moved_on(store, version.manifest)) return {};
  if (lock != LockResult::kConflict && store.contains(name, version.file.descriptor()))
    return version;
  const StoreLock free_now(store,
                           LockFor::kReading);  // throws kBusy if there is a writer, and names it
  return {};
}

std::vector<std::uint64_t> versions_being_read(const Directory& store, std::uint64_t newest) {
  std::vector<std::uint64_t> versions = versions_there(store);
  std::erase_if(versions, [&](std::uint64_t version) {
    return version >= newest || !is_being_read(store, version);
  });
  return versions;
}

std::vector<File> keep_all_readers_out(const Directory& store) {
  std::vector<File> files;
  for (const std::uint64_t version : versions_there(store)) {
    File file;
    try {
      file = open_to_exclude(store, version_file_name(version));
    } catch (const Error& error) {
      if (error.code() != ErrorCode::kNotFound && error.code() != ErrorCode::kCorruption) throw;
      continue;  // not a regular file, so no reader has it open
    }
    if (try_lock(file, true) == LockResult::kConflict)
      throw Error(ErrorCode::kBusy, fmt::format("open {} exclusively: readers have version {} open",
                                                store.path().native(), version));
    files.push_back(std::move(file));
  }
  return files;
}

OpenVersion open_older_version(const Directory& store, const StoreUuid& uuid,
                               std::uint64_t sequence, std::uint32_t features_of_all) {
  OpenVersion version;
  version.file = File(store, version_file_name(sequence), OpenMode::kRead);
  version.manifest.uuid = uuid;
  version.manifest.sequence = version.manifest.described = sequence;
  version.manifest.version_bytes = version.file.size();
  version.manifest.required_features = features_of_all;
  version.is_newest = false;
  return version;
}

PLAIT_END_NAMESPACE
