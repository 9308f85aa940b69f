// The rollback journal: what blocks of the last committed version held before they are overwritten
// in place, so that the version can be put back after a crash. Bytes: docs/format.md, "journal".
//
// Invariants
//  1. A block of the committed version is in the journal, and the journal on the disk, before the
//     first byte of it is overwritten.
//  2. The journal belongs to one version of one store. It is hot while the manifest names that
//     version as its newest; from the next one's manifest slot on it means nothing and is removed.
//  3. Putting blocks back may be interrupted and begun again any number of times.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "plait/block_table.h"
#include "plait/directory.h"
#include "plait/file.h"
#include "plait/level_geometry.h"
#include "store/stored_version.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Safe from several threads.
class RollbackJournal {
 public:
  /// Makes no file and takes no memory before the first keep(), which copies blocks through a
  /// buffer of `buffer_bytes` bytes. REQUIRES: at least one byte. `store` outlives this object.
  RollbackJournal(const Directory& store, const StoreUuid& uuid, std::uint64_t sequence,
                  std::size_t buffer_bytes);
  std::size_t buffer_bytes() const noexcept { return buffer_bytes_; }

  /// Enters blocks of a level, as its file `name` has them, good or damaged. On the disk when it
  /// returns. Errors: kIo, kNoSpace; the blocks must not be overwritten then.
  void keep(const std::string& name, const BlockTable& table, const LevelGeometry& geometry,
            std::span<const std::uint64_t> blocks);

  /// Version `sequence` has been committed: what was kept is of no use any more.
  void begin_version(std::uint64_t sequence);

 private:
  void create();

  const Directory& store_;
  StoreUuid uuid_;
  std::atomic<std::uint64_t> sequence_;
  std::mutex mutex_;
  File file_;
  std::uint64_t end_ = 0, seed_ = 0;
  std::size_t buffer_bytes_;
  std::vector<std::byte> buffer_;
};

/// Whether the store has a journal of version `sequence`. Another process may remove the journal
/// meanwhile. Errors: kIo; kCorruption for anything but a regular file.
bool is_hot_journal(const Directory& store, const StoreUuid& uuid, std::uint64_t sequence);

/// Puts back what the store's journal holds of version `sequence`, its newest one, makes that
/// durable, and removes the journal. Returns the number of blocks. A torn end is ignored: what it
/// stood for was never overwritten. Nothing is written before every record is known to be of a
/// block of `levels`, which are those of the version, in its place. REQUIRES: the writer's lock; a
/// hot journal.
/// Errors: kCorruption for a record that no journal of this version can have; kIo, kNoSpace.
std::uint64_t roll_back(const Directory& store, const StoreUuid& uuid, std::uint64_t sequence,
                        std::span<const StoredLevel> levels);

/// Durably. Errors: kIo.
void remove_journal(const Directory& store);

PLAIT_END_NAMESPACE
