#include "store/recovery.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "plait/error.h"
#include "store/file_names.h"
#include "store/rollback_journal.h"

namespace plait {
namespace {

namespace fs = std::filesystem;

/// What may keep a reader waiting is another one that is putting blocks back, or about to.
constexpr int kAttempts = 25;
constexpr std::chrono::milliseconds kPause{20};

bool must_be_undone(const Directory& store) {
  if (!store.contains(kJournalName)) return false;
  const Manifest manifest = read_manifest(store);
  return is_hot_journal(store, manifest.uuid, manifest.sequence);
}

void undo(const Directory& store) {
  const Manifest manifest = read_manifest(store);
  roll_back(store, manifest.uuid, manifest.sequence);
}

/// A slot whose sync failed may be what is read and yet not what is on the disk. Written once more
/// it becomes both; torn it is what it was.
void write_newest_slot_again(const Directory& store) {
  File file(store, kManifestName, OpenMode::kReadWrite);
  write_manifest(file, read_manifest(file));
  file.sync();
  file.close();
  store.sync();
}

StoreLock lock_for_reading(const Directory& store) {
  for (int attempt = 1;; ++attempt) {
    try {
      {
        StoreLock lock(store, LockFor::kReading);
        if (!must_be_undone(store)) return lock;
      }
      // A writer may have come and gone, and left a slot of which nobody knows that it is durable:
      // the journal of the version before is the next writer's to remove.
      const StoreLock lock(store, LockFor::kRecovering);
      if (must_be_undone(store)) undo(store);
    } catch (const Error& error) {
      // Without the lock nothing of the store may be read, but this much is known: where there is
      // no journal nobody is putting blocks back.
      if (error.code() != ErrorCode::kBusy || attempt == kAttempts || !store.contains(kJournalName))
        throw;
      std::this_thread::sleep_for(kPause);
    }
  }
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
  // With one of the two it may be a damaged store.
  if (!store.contains(kManifestName) && !store.contains(kLockName))
    throw Error(ErrorCode::kNotFound,
                fmt::format("open {}: expected a store, found a directory with neither {} nor {}",
                            path.native(), kManifestName, kLockName));
  return store;
}

StoreLock lock_recovered(const Directory& store, bool writable, Durability durability) {
  if (!writable) return lock_for_reading(store);
  StoreLock lock(store, LockFor::kWriting);
  read_manifest(store);  // only what is a store is written into
  lock.sign();
  // Before anything goes that the version before the newest one would need.
  if (durability == Durability::kCommit || store.contains(kJournalName))
    write_newest_slot_again(store);
  undo(store);
  remove_left_over_files(store);
  return lock;
}

void remove_if_never_committed(const fs::path& path) {
  if (!fs::is_directory(path)) return;
  const Directory store(path);
  for (const std::string& name : store.names())
    if (name != kManifestName && name != kLockName && name != kBaseMeshName &&
        !is_version_file_name(name))
      return;
  std::optional<File> lock;
  if (store.contains(kLockName)) {
    lock.emplace(store, kLockName, OpenMode::kRead);
    if (!lock->lock(true)) return;
  }
  if (is_uncommitted(store)) remove_uncommitted(store);
}

bool is_uncommitted(const Directory& store) {
  return is_blank_manifest(store) ||
         std::ranges::all_of(store.names(),
                             [](const std::string& name) { return name == kLockName; });
}

void remove_uncommitted(const Directory& store) noexcept {
  try {
    // A slot that was written in vain must not name what is gone.
    if (store.contains(kManifestName) && !is_blank_manifest(store)) {
      store.remove(kManifestName);
      create_blank_manifest(store);
    }
  } catch (...) {  // then it goes first
    store.remove_if_possible(kManifestName);
  }
  try {
    for (const std::string& name : store.names())
      if (name != kManifestName && name != kLockName) store.remove_if_possible(name);
    store.remove_if_possible(kManifestName);
    store.remove_if_possible(kLockName);
    store.remove_itself();
  } catch (...) {  // nobody can be told; it is replaced by the next one of this name
  }
}

void remove_left_over_files(const Directory& store) noexcept {
  try {
    std::set<std::string> named;
    const File file(store, kManifestName, OpenMode::kRead);
    const Manifest newest = read_manifest(file);
    for (const ManifestAttribute& attribute : newest.attributes)
      for (int level = newest.base_level + 1; level <= attribute.finest_level; ++level)
        named.insert(level_file_name(attribute.number, level));
    for (const Manifest& version : read_whole_slots(file)) {
      named.insert(tables_file_name(version.sequence));
      for (const ManifestAttribute& attribute : version.attributes)
        named.insert(base_file_name(attribute.number, version.sequence));
    }
    for (const std::string& name : store.names())
      if (is_version_file_name(name) && !named.contains(name)) store.remove_if_possible(name);
  } catch (...) {  // what stays is in nobody's way
  }
}

}  // namespace plait
