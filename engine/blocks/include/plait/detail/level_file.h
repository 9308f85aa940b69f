// plait/detail/level_file.h: an open level of one attribute, and the record of which levels and
// base records are unfinished.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "plait/detail/namespace.h"
#include "plait/extend/backend.h"

PLAIT_BEGIN_NAMESPACE

class KeptBlocks;
struct Frame;

/// How the owner of a pin uses the block, or how a pass uses a level.
enum class Access : std::uint8_t {
  kRead,
  kOverwrite,  ///< writes all of it, so the pager does not read it first
  kUpdate,     ///< reads it and then changes it
};

/// Whether the records of a level, or the base records of an attribute, are those of one moment.
/// What is not finished must not be read or committed (StoreAccess::check_readable).
struct WrittenRecords {
  /// Whether all passes that wrote to the records have finished.
  bool is_finished() const noexcept { return !left_unfinished && passes_under_way == 0; }
  /// Set by UnfinishedLevels, PinnedBlock::abandon() and patches.
  std::atomic<bool> left_unfinished = false;
  std::atomic<std::uint32_t> passes_under_way = 0;  ///< counted by UnfinishedLevels
  /// For messages: a face that a PatchWriter left out. Passes that begin forget it.
  std::uint32_t first_missing_face = kNoId;
};

/// One open level of one attribute. Not movable, because the backend has references to its members.
/// A const level can only be read; blocks are pinned for writing through a level that is not const.
struct LevelFile : WrittenRecords {
  LevelGeometry geometry;
  BlockTable table;
  std::filesystem::path path;
  std::string attribute = {};  ///< the name that it had when the level was opened
  std::unique_ptr<Backend> backend;
  BackendTraits traits;
  Pipeline pipeline = {};  ///< how the backend encodes blocks
  bool writable = true;    ///< false if the level was opened for reading
  /// Other levels were encoded with the help of this one (Backend::context), so it can no longer be
  /// changed: they would decode to wrong records.
  mutable std::atomic<bool> is_fixed = false;
  /// What the last commit has of a level in memory. Not set for other levels, and for new ones.
  std::shared_ptr<KeptBlocks> committed;
  // For use by the pager only:
  std::uint32_t pager_slot = kNoId;
  const std::atomic<Frame*>* frames = nullptr;  ///< [block] its frame or nullptr
  int run_log2 = 0;                             ///< blocks move in runs of 2^run_log2: see run_of()
};

/// The most that LevelFile::run_log2 is with this geometry.
int most_run_log2(const LevelGeometry& geometry) noexcept;

/// The run of blocks that `block` moves with, if all of them are to be moved: at most kRunBytes,
/// cut at the same places by everybody, so that runs that are filled in any order come out whole.
BlockRange run_of(const LevelFile& level, std::uint64_t block) noexcept;

/// Whether blocks of the level may need blocks of other levels (Backend::context).
bool needs_other_blocks(const LevelFile& level) noexcept;

/// Throws kBadState if blocks of one of the levels are encoded from another one: a pass that writes
/// both would change what it encodes from.
void check_not_encoded_from_each_other(std::span<const LevelFile* const> written);

/// Throws kBadState for a level that is fixed. The message names the ways to change its records.
void check_not_fixed(const LevelFile& level);

/// Marks levels and base records as unfinished while a pass writes to them, from add() to finish().
/// If finish() is not called, for example after an error, they stay unfinished until a pass has
/// overwritten each of them as a whole. The executors use one object for each pass. A work of
/// several passes, or one that writes through pins, has one object around all of them. Threads: one
/// (docs/threads.md).
class UnfinishedLevels {
 public:
  UnfinishedLevels() = default;
  ~UnfinishedLevels();
  UnfinishedLevels(const UnfinishedLevels&) = delete;
  UnfinishedLevels& operator=(const UnfinishedLevels&) = delete;
  /// `access` tells how the pass uses the whole level; with kRead the call does nothing. The
  /// backend learns that all blocks will be written (Advice::kOverwrite). The level must outlive
  /// this object. Errors: kBadState as check_not_fixed().
  void add(LevelFile& level, Access access);
  /// The same for base records: StoreAccess::base_records_of().
  void add_base(WrittenRecords& records, Access access);
  void finish() noexcept;

 private:
  struct Added {
    WrittenRecords* records;
    Access access;
  };
  std::vector<Added> added_;
};

PLAIT_END_NAMESPACE
