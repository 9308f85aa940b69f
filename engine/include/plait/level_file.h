// plait/level_file.h: one level of one attribute, open; and which levels are not whole.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "plait/backend.h"

namespace plait {

/// What a block is pinned for, or what a pass does to a level.
enum class Access : std::uint8_t {
  kRead,
  kWrite,   ///< all of it will be written: nothing is read
  kUpdate,  ///< read, then written
};

/// One level of one attribute, open. Not movable: backend and geometry point into it. A const level
/// can be read; only what is not const can be pinned for writing.
struct LevelFile {
  LevelGeometry geometry;
  BlockTable table;
  std::filesystem::path path;
  std::unique_ptr<Backend> backend;
  BackendTraits traits;
  std::string pipeline = "none";     ///< how the backend encodes blocks
  bool writable = true;              ///< false: opened for reading
  std::uint32_t pager_slot = kNoId;  ///< the pager's; nobody else's

  /// Whether no pass that writes to it is under way or was left half done: otherwise the level must
  /// not be committed. While nobody else works on the level.
  bool is_finished() const noexcept { return !left_unfinished && passes_under_way == 0; }
  bool left_unfinished = false;        ///< by UnfinishedLevels, PinnedBlock::abandon(), patches
  std::uint32_t passes_under_way = 0;  ///< counted by UnfinishedLevels
};

/// What a pass, or several that count only together, write to: from add() to finish() the levels
/// are unfinished, and if finish() is never called, because of an error say, they stay so until a
/// pass has overwritten them whole. The executors have one for each pass; who changes a level with
/// several passes, or by pins, keeps one around them. One thread.
class UnfinishedLevels {
 public:
  UnfinishedLevels() = default;
  ~UnfinishedLevels();
  UnfinishedLevels(const UnfinishedLevels&) = delete;
  UnfinishedLevels& operator=(const UnfinishedLevels&) = delete;
  /// `access` is what the pass does to the whole level; kRead: nothing happens. The level outlives
  /// this object.
  void add(LevelFile& level, Access access);
  void finish() noexcept;

 private:
  struct Added {
    LevelFile* level;
    Access access;
  };
  std::vector<Added> levels_;
};

}  // namespace plait
