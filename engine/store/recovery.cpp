#include "store/recovery.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <chrono>
#include <ctime>
#include <optional>
#include <set>
#include <string>
#include <system_error>
#include <vector>

#include "format/file_names.h"
#include "io/locks.h"
#include "plait/error.h"
#include "store/old_versions.h"
#include "store/store_directory.h"
#include "store/stored_version.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

namespace fs = std::filesystem;

/// The number of attempts to lock the newest version. An attempt fails if a writer commits another
/// version at that moment.
constexpr int kMostVersions = 100'000;

/// If syncing a manifest slot failed, the page cache may hold a slot that the disk does not. The
/// writer writes the slot again and syncs it. If that write is torn, the other slot still holds the
/// commit before.
void write_newest_slot_again(const Directory& store) {
  File file(store, kManifestName, OpenMode::kReadWrite);
  write_manifest(file, read_manifest(file));
  file.sync();
  file.close();
  store.sync();
}

/// A store that another process is making has no version yet. Then the error is kBusy, and names
/// this process.
[[noreturn]] void throw_busy_or(const Error& error, const Directory& store) {
  if (error.code() != ErrorCode::kCorruption) throw error;
  try {
    const StoreLock free_now(store, LockFor::kReading);
  } catch (const Error& of_lock) {
    if (of_lock.code() == ErrorCode::kBusy) throw;
  }
  throw error;
}

}  // namespace

Directory open_store_directory(const fs::path& path) {
  Directory store;
  try {
    store = Directory(path);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kNotFound) throw;
    std::error_code ignored;
    throw Error(ErrorCode::kNotFound,
                fs::exists(path, ignored)
                    ? fmt::format("open {}: expected a store, which is a directory, found a file",
                                  path.native())
                    : fmt::format("open {}: no such store", path.native()))
        .about(path);
  }
  // A directory with a lock may be a damaged store.
  if (!store.contains(kLockName) && !has_whole_slot(store))
    throw Error(
        ErrorCode::kNotFound,
        fmt::format("open {}: expected a store, found a directory with neither a {} nor the "
                    "{} of a store",
                    path.native(), kLockName, kManifestName))
        .about(path);
  return store;
}

OpenVersion open_for_reading(const Directory& store) {
  for (int attempt = 0; attempt < kMostVersions; ++attempt) {
    try {
      if (std::optional<OpenVersion> version = share_newest_version(store))
        return std::move(*version);
    } catch (const Error& error) {
      throw_busy_or(error, store);
    }
  }
  throw Error(ErrorCode::kBusy,
              fmt::format("open {}: in each of {} attempts, a writer committed another version",
                          store.path().native(), kMostVersions));
}

StoreLock lock_for_writing(const Directory& store, Durability durability) {
  StoreLock lock(store, LockFor::kWriting);
  read_manifest(store);  // throws if the directory is not a store, before anything is written
  lock.sign();
  // This must be done before anything is removed that the version before the newest one needs.
  if (durability == Durability::kCommit) write_newest_slot_again(store);
  return lock;
}

namespace {

void remove_if_never_committed(const Directory& store) {
  // A process that creates a store has a shared lock on the directory before it makes the first
  // file.
  if (try_lock(store, true) == LockResult::kConflict || !is_uncommitted(store)) return;
  for (const std::string& name : store.names())
    if (name != kManifestName && name != kLockName && name != kBaseMeshName &&
        name != kDepthsName && !is_base_index_name(name) && !is_version_file_name(name) &&
        !is_bounds_file_name(name))
      return;
  std::optional<File> lock;
  if (store.contains(kLockName)) lock = open_to_exclude(store, kLockName);
  if (lock && try_lock(*lock, true) == LockResult::kConflict) return;
  remove_uncommitted(store);
}

/// Returns the directory if it is empty: the user may have made it for the store. If a killed
/// writer left it before its first commit, removes it.
std::optional<Directory> open_empty(const fs::path& path) {
  std::error_code ignored;
  if (!fs::is_directory(path, ignored)) return std::nullopt;
  Directory directory(path);
  if (!directory.names().empty()) {
    remove_if_never_committed(directory);
    return std::nullopt;
  }
  return directory;
}

}  // namespace

Directory claim_store_directory(const fs::path& path, Durability durability) {
  std::optional<Directory> directory = open_empty(path);
  const auto taken = [&] {
    return Error(ErrorCode::kInvalidArgument,
                 fmt::format("create {}: it exists already", path.native()))
        .about(path);
  };
  std::error_code ignored;
  if (!directory) {
    if (fs::exists(fs::symlink_status(path, ignored))) throw taken();
    directory = Directory::make(path);
  }
  try {
    if (try_lock(*directory, false) == LockResult::kConflict)
      throw taken();  // another process is removing it
    create_begun_manifest(*directory, durability == Durability::kCommit);
  } catch (...) {
    try {
      directory->remove_itself();  // does nothing if another process has made files in it
    } catch (const Error&) {       // the caller gets the first error
    }
    throw;
  }
  return std::move(*directory);
}

bool is_uncommitted(const Directory& store) {
  const std::vector<std::string> names = store.names();
  if (names.empty()) return true;
  if (names == std::vector<std::string>{kManifestName}) return is_begun_manifest_in_part(store);
  return is_begun_manifest(store);
}

void remove_uncommitted(const Directory& store) noexcept {
  try {
    // A slot of a failed commit must not name files that are removed.
    begin_manifest_again(store);
    for (const std::string& name : store.names())
      if (is_store_file_name(name) && name != kLockName && name != kManifestName)
        store.remove_if_possible(name);
    store.remove_if_possible(kLockName);
    if (store.names() == std::vector<std::string>{kManifestName})
      store.remove_if_possible(kManifestName);
    store.remove_itself();
  } catch (const std::exception&) {  // the next store of this name replaces the remaining files
  }
}

namespace {

struct stat file_status(const Directory& store, const std::string& name) {
  struct stat status {};
  ::fstatat(store.descriptor(), name.c_str(), &status, AT_SYMLINK_NOFOLLOW);
  return status;
}

/// Whether a version that may be read was replaced so long ago, and no lock on it is seen.
bool is_given_up(const Directory& store, std::uint64_t version, std::uint64_t next,
                 std::chrono::seconds age) {
  const std::time_t replaced = file_status(store, version_file_name(next)).st_mtim.tv_sec;
  if (replaced == 0 || std::time(nullptr) - replaced < age.count()) return false;
  File file = open_to_exclude(store, version_file_name(version));
  return try_lock(file, true) != LockResult::kConflict;
}

/// The name of the change log that an older version may need: the newest one that was there when
/// the version was. (A version with a file of its own makes each log, and a store has one at a
/// time.) Of no file if there is none.
std::string change_log_of(const std::vector<std::string>& names, std::uint64_t version) {
  std::uint64_t newest = 0;
  for (const std::string& name : names)
    if (const auto made = change_log_generation(name); made && *made <= version)
      newest = std::max(newest, *made);
  return change_log_name(newest);
}

/// Calls remove(name) for each file that only old versions need, but those that may be read and
/// are not given up after `age`. Returns the versions that keep their files.
template <class Remove>
std::vector<std::uint64_t> for_each_old_file(const Directory& store,
                                             std::optional<std::chrono::seconds> age,
                                             Remove remove) {
  const StoredVersion newest(store, open_newest_version(store));
  const Manifest& manifest = newest.manifest();
  std::vector<std::uint64_t> held = versions_being_read(store, manifest.described);
  if (age) {
    std::vector<std::uint64_t> kept;
    for (std::size_t at = 0; at < held.size(); ++at)
      if (!is_given_up(store, held[at], at + 1 < held.size() ? held[at + 1] : manifest.described,
                       *age))
        kept.push_back(held[at]);
    held = kept;
  }
  std::set<std::string> needed = newest.file_names();
  const std::vector<std::string> names = store.names();
  try {
    for (const std::uint64_t version : held) needed.insert(change_log_of(names, version));
    for (const std::uint64_t version : held)
      needed.merge(StoredVersion(store, open_older_version(store, manifest.uuid, version))
                       .file_names(newest.shard_count()));
  } catch (const Error&) {  // it is not known which files the version needs, so all stay
    return held;
  }
  std::set<std::string> bounds;
  for (const AttributeRecord& attribute : newest.description().attributes)
    bounds.insert(bounds_file_name(attribute.number));
  const std::vector<Manifest> slots = read_whole_slots(File(store, kManifestName, OpenMode::kRead));
  for (const std::string& name : names) {
    const bool is_of_a_slot = std::ranges::any_of(
        slots, [&](const Manifest& slot) { return is_of_version_alone(name, slot.described); });
    if (is_version_file_name(name) && !needed.contains(name) && !is_of_a_slot) remove(name);
    if ((is_bounds_file_name(name) && !bounds.contains(name)) || name == kNewBaseIndexName)
      remove(name);
  }
  return held;
}

}  // namespace

std::vector<std::uint64_t> remove_old_versions(const Directory& store) {
  return for_each_old_file(store, std::nullopt,
                           [&](const std::string& name) { store.remove_if_possible(name); });
}

RemovedVersions remove_versions_replaced_before(const Directory& store, std::chrono::seconds age,
                                                bool dry_run) {
  const StoreLock lock = lock_for_writing(store, dry_run ? Durability::kNone : Durability::kCommit);
  RemovedVersions removed;
  const auto count = [&](const std::string& name) {
    const auto blocks = static_cast<std::uint64_t>(file_status(store, name).st_blocks);
    if (!dry_run) store.remove_if_possible(name);
    if (!dry_run && store.contains(name)) return;
    ++removed.files;
    removed.bytes += 512 * blocks;
  };
  removed.versions_kept = for_each_old_file(store, age, count).size();
  return removed;
}

PLAIT_END_NAMESPACE
