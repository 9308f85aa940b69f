#include "store/recovery.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <optional>
#include <set>
#include <string>
#include <system_error>
#include <thread>
#include <vector>

#include "plait/error.h"
#include "plait/store_directory.h"
#include "store/file_names.h"
#include "store/rollback_journal.h"
#include "store/stored_version.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

namespace fs = std::filesystem;

/// A reader waits only for a process that restores blocks from the journal, or will do so.
constexpr int kRecoveryAttempts = 25;
constexpr std::chrono::milliseconds kPause{20};
/// The number of attempts to lock the newest version. An attempt fails if a writer commits another
/// version at that moment.
constexpr int kMostVersions = 100'000;

/// The levels with their block tables. If the tables are damaged, the geometry of the levels is
/// enough: after the blocks are restored, repair may make the tables again.
std::vector<StoredLevel> levels_of(const StoredVersion& version, const BaseMesh& base) {
  std::vector<StoredLevel> levels = version.levels(base);
  try {
    version.read_tables_into(levels);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kCorruption && error.code() != ErrorCode::kNotFound) throw;
  }
  return levels;
}

/// Restores the blocks that a hot journal has saved, if the store has one, and removes it.
void undo(const Directory& store) {
  const Manifest manifest = read_manifest(store);
  if (!is_hot_journal(store, manifest.uuid, manifest.sequence)) return;
  const StoredVersion version(store, open_newest_version(store));
  const BaseMesh base = version.read_base_mesh();
  roll_back(store, manifest.uuid, manifest.sequence, levels_of(version, base));
}

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
    throw Error(ErrorCode::kNotFound, fmt::format("open {}: no such store", path.native()));
  }
  // A directory with a lock may be a damaged store.
  if (!store.contains(kLockName) && !has_whole_slot(store))
    throw Error(
        ErrorCode::kNotFound,
        fmt::format("open {}: expected a store, found a directory with neither a {} nor the "
                    "{} of a store",
                    path.native(), kLockName, kManifestName));
  return store;
}

OpenVersion open_for_reading(const Directory& store) {
  int busy = 0;
  for (int attempt = 0; attempt < kMostVersions; ++attempt) {
    try {
      std::optional<OpenVersion> version = share_newest_version(store);
      if (!version) continue;
      const Manifest& newest = version->manifest;
      if (!is_hot_journal(store, newest.uuid, newest.sequence)) return std::move(*version);
      version.reset();
      // The journal may belong to the version before the newest one, if a writer has left a slot
      // that may not be durable. Only the next writer may remove that journal.
      const StoreLock lock(store, LockFor::kRecovering);
      undo(store);
    } catch (const Error& error) {
      if (error.code() != ErrorCode::kBusy) throw_busy_or(error, store);
      // Without a journal, no process can be restoring blocks.
      if (++busy == kRecoveryAttempts || !store.contains(kJournalName)) throw;
      std::this_thread::sleep_for(kPause);
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
  if (durability == Durability::kCommit || store.contains(kJournalName))
    write_newest_slot_again(store);
  undo(store);
  // A journal of another version has no meaning.
  if (store.contains(kJournalName)) remove_journal(store);
  return lock;
}

namespace {

void remove_if_never_committed(const Directory& store) {
  // A process that creates a store has a shared lock on the directory before it makes the first
  // file.
  if (!store.lock(true) || !is_uncommitted(store)) return;
  for (const std::string& name : store.names())
    if (name != kManifestName && name != kLockName && name != kBaseMeshName &&
        !is_version_file_name(name) && !is_bounds_file_name(name))
      return;
  std::optional<File> lock = open_if_present(store, kLockName, OpenMode::kRead);
  if (lock && !lock->lock(true)) return;
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
                 fmt::format("create {}: it exists already", path.native()));
  };
  std::error_code ignored;
  if (!directory) {
    if (fs::exists(fs::symlink_status(path, ignored))) throw taken();
    directory = Directory::make(path);
  }
  try {
    if (!directory->lock(false)) throw taken();  // another process is removing it
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
  } catch (...) {  // the next store of this name replaces the remaining files
  }
}

std::vector<std::uint64_t> remove_old_versions(const Directory& store) {
  const StoredVersion newest(store, open_newest_version(store));
  const Manifest& manifest = newest.manifest();
  std::vector<std::uint64_t> held = versions_being_read(store, manifest.sequence);
  std::set<std::string> needed = newest.file_names();
  try {
    for (const std::uint64_t version : held)
      needed.merge(
          StoredVersion(store, open_older_version(store, manifest.uuid, version)).file_names());
  } catch (const Error&) {  // it is not known which files the version needs, so all stay
    return held;
  }
  std::set<std::string> bounds;
  for (const AttributeRecord& attribute : newest.description().attributes)
    bounds.insert(bounds_file_name(attribute.number));
  const std::vector<Manifest> slots = read_whole_slots(File(store, kManifestName, OpenMode::kRead));
  for (const std::string& name : store.names()) {
    const bool is_of_a_slot = std::ranges::any_of(
        slots, [&](const Manifest& slot) { return is_of_version_alone(name, slot.sequence); });
    if (is_version_file_name(name) && !needed.contains(name) && !is_of_a_slot)
      store.remove_if_possible(name);
    if (is_bounds_file_name(name) && !bounds.contains(name)) store.remove_if_possible(name);
  }
  return held;
}

PLAIT_END_NAMESPACE
