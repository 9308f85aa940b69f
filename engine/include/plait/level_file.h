// plait/level_file.h: an open level of one attribute, and the record of which levels are
// unfinished.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "plait/backend.h"
#include "plait/namespace.h"

PLAIT_BEGIN_NAMESPACE

/// How the owner of a pin uses the block, or how a pass uses a level.
enum class Access : std::uint8_t {
  kRead,
  kOverwrite,  ///< writes all of it, so the pager does not read it first
  kUpdate,     ///< reads it and then changes it
};

/// One open level of one attribute. Not movable, because the backend has references to its members.
/// A const level can only be read; blocks are pinned for writing through a level that is not const.
struct LevelFile {
  LevelGeometry geometry;
  BlockTable table;
  std::filesystem::path path;
  std::unique_ptr<Backend> backend;
  BackendTraits traits;
  std::string pipeline = "none";  ///< how the backend encodes blocks
  bool writable = true;           ///< false if the level was opened for reading
  /// Other levels were encoded with the help of this one (Backend::context), so it can no longer be
  /// changed: they would decode to wrong records.
  mutable std::atomic<bool> is_fixed = false;
  /// The blocks are computed when they are read (plait/derivation.h). The level cannot be written.
  bool is_derived = false;
  /// The levels that the blocks of a derived level are computed from.
  std::vector<const LevelFile*> made_from = {};
  /// Counts beginnings and ends of pins for writing, and changes of the base records.
  mutable std::atomic<std::uint64_t> changes = 0;
  std::uint32_t writers = 0;         ///< pins for writing that have not ended; for the pager only
  std::uint32_t pager_slot = kNoId;  ///< for use by the pager only

  /// Another number after each change of what the blocks are computed from.
  std::uint64_t state() const noexcept {
    std::uint64_t sum = changes;
    for (const LevelFile* const level : made_from) sum += level->changes;
    return sum;
  }

  /// Whether all passes that wrote to the level have finished. A level that is not finished must
  /// not be committed. REQUIRES: no other thread pins blocks of the level or begins a pass at the
  /// same time.
  bool is_finished() const noexcept { return !left_unfinished && passes_under_way == 0; }
  bool left_unfinished = false;        ///< set by UnfinishedLevels, PinnedBlock::abandon(), patches
  std::uint32_t passes_under_way = 0;  ///< counted by UnfinishedLevels
};

/// Throws kBadState for a level that is fixed or derived. The message names the ways to change its
/// records.
void check_not_fixed(const LevelFile& level);

/// Marks levels as unfinished while a pass writes to them, from add() to finish(). If finish() is
/// not called, for example after an error, the levels stay unfinished until a pass has overwritten
/// each of them as a whole. The executors use one object for each pass. A program that changes a
/// level in several passes, or through pins, uses one object around all of them. For one thread.
class UnfinishedLevels {
 public:
  UnfinishedLevels() = default;
  ~UnfinishedLevels();
  UnfinishedLevels(const UnfinishedLevels&) = delete;
  UnfinishedLevels& operator=(const UnfinishedLevels&) = delete;
  /// `access` tells how the pass uses the whole level; with kRead the call does nothing. The level
  /// must outlive this object. Errors: kBadState as check_not_fixed().
  void add(LevelFile& level, Access access);
  void finish() noexcept;

 private:
  struct Added {
    LevelFile* level;
    Access access;
  };
  std::vector<Added> levels_;
};

PLAIT_END_NAMESPACE
