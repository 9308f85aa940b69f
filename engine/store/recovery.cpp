#include "store/recovery.h"

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

bool has_journal(const fs::path& store) {
  return fs::exists(fs::symlink_status(RollbackJournal::path_in(store)));
}

bool must_be_undone(const fs::path& store) {
  if (!has_journal(store)) return false;
  const Manifest manifest = read_manifest(store / kManifestName);
  return is_hot_journal(store, manifest.uuid, manifest.sequence);
}

void undo(const fs::path& store) {
  const Manifest manifest = read_manifest(store / kManifestName);
  roll_back(store, manifest.uuid, manifest.sequence);
}

/// A slot whose sync failed may be what is read and yet not what is on the disk. Written once more
/// it becomes both; torn it is what it was.
void write_newest_slot_again(const fs::path& store) {
  File file(store / kManifestName, OpenMode::kReadWrite);
  write_manifest(file, read_manifest(file));
  file.sync();
  file.close();
  sync_directory(store);
}

StoreLock lock_for_reading(const fs::path& store) {
  for (int attempt = 1;; ++attempt) {
    try {
      {
        StoreLock lock(store / kLockName, false, false);
        if (!must_be_undone(store)) return lock;
      }
      // A writer may have come and gone, and left a slot of which nobody knows that it is durable:
      // the journal of the version before is the next writer's to remove.
      const StoreLock lock(store / kLockName, true, false);
      if (must_be_undone(store)) undo(store);
    } catch (const Error& error) {
      // Without the lock nothing of the store may be read, but this much is known: where there is
      // no journal nobody is putting blocks back.
      if (error.code() != ErrorCode::kBusy || attempt == kAttempts || !has_journal(store)) throw;
      std::this_thread::sleep_for(kPause);
    }
  }
}

}  // namespace

StoreLock lock_recovered(const fs::path& store, bool writable, Durability durability) {
  if (!writable) return lock_for_reading(store);
  StoreLock lock(store / kLockName, true, false);
  // Before anything goes that the version before the newest one would need.
  if (durability == Durability::kCommit || has_journal(store)) write_newest_slot_again(store);
  undo(store);
  remove_left_over_files(store);
  return lock;
}

void remove_if_never_committed(const fs::path& store) {
  if (!fs::is_directory(store)) return;
  for (const fs::directory_entry& entry : fs::directory_iterator(store)) {
    const std::string name = entry.path().filename().string();
    if (name != kManifestName && name != kLockName && name != kBaseMeshName &&
        !is_version_file_name(name))
      return;
  }
  std::optional<File> lock;
  if (fs::exists(store / kLockName)) {
    lock.emplace(store / kLockName, OpenMode::kReadWrite);
    if (!lock->lock(true)) return;
  }
  if (is_uncommitted(store)) remove_uncommitted(store);
}

bool is_uncommitted(const fs::path& store) {
  if (is_blank_manifest(store / kManifestName)) return true;
  return std::ranges::all_of(fs::directory_iterator(store), [](const fs::directory_entry& entry) {
    return entry.path().filename() == kLockName;
  });
}

void remove_uncommitted(const fs::path& store) noexcept {
  const fs::path manifest = store / kManifestName, lock = store / kLockName;
  try {
    // A slot that was written in vain must not name what is gone.
    if (fs::exists(manifest) && !is_blank_manifest(manifest)) {
      remove_file(manifest);
      create_blank_manifest(manifest);
    }
  } catch (...) {  // then it goes first
    remove_file_if_possible(manifest);
  }
  try {
    std::vector<fs::path> files;
    for (const fs::directory_entry& entry : fs::directory_iterator(store))
      if (entry.path() != manifest && entry.path() != lock) files.push_back(entry.path());
    files.insert(files.end(), {manifest, lock});
    for (const fs::path& file : files) remove_file_if_possible(file);
    fs::remove(store);
  } catch (...) {  // nobody can be told; it is replaced by the next one of this name
  }
}

void remove_left_over_files(const fs::path& store) noexcept {
  try {
    std::set<std::string> named;
    const File file(store / kManifestName, OpenMode::kRead);
    const Manifest newest = read_manifest(file);
    for (const ManifestAttribute& attribute : newest.attributes)
      for (int level = newest.base_level + 1; level <= attribute.finest_level; ++level)
        named.insert(level_file_name(attribute.number, level));
    for (const Manifest& version : read_whole_slots(file)) {
      named.insert(tables_file_name(version.sequence));
      for (const ManifestAttribute& attribute : version.attributes)
        named.insert(base_file_name(attribute.number, version.sequence));
    }
    for (const fs::directory_entry& entry : fs::directory_iterator(store)) {
      const std::string name = entry.path().filename().string();
      if (is_version_file_name(name) && !named.contains(name)) remove_file_if_possible(entry);
    }
  } catch (...) {  // what stays is in nobody's way
  }
}

}  // namespace plait
