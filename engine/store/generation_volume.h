// A volume around one whose backends overwrite in place. It stores a level in a file of its own,
// the level's generation, and few changed blocks of all levels in the store's change log. The block
// table says which of the two has a block.
//
// Invariants
//  1. No byte of a block changes that the newest version names, or a version that a reader may have
//     open.
//  2. A block of the committed version that is written anew goes to the change log, or to a new
//     generation, if half of the level's blocks change or a pass is to change all.
//  3. When the log has nearly half as many bytes as the levels, the version gets a file of its own.
//     The next block begins a new log, and the commit moves what still counts of the former one
//     (generation_fold.cpp). A block also begins a new log if the former one has half of the bytes.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "format/change_record.h"
#include "plait/extend/backend.h"
#include "plait/extend/directory.h"
#include "store/change_log.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

class GenerationLevel;

/// Where the blocks of a level are. An offset in one of the volume's two logs, with kInLog and
/// kInSecondLog in its low bits, or one of the first two.
using BlockPlace = std::uint64_t;
inline constexpr BlockPlace kInLevelFile = 0, kInNewFile = 1, kInLog = 2, kInSecondLog = 3;
constexpr bool is_in_log(BlockPlace place) { return (place & kInLog) != 0; }
constexpr std::uint64_t log_offset(BlockPlace place) { return place & ~kInSecondLog; }

class GenerationVolume final : public Volume {
 public:
  /// `store` outlives this object. Version `sequence` is the committed one, and `log` is its change
  /// log. Errors: those of ChangeLog.
  GenerationVolume(std::unique_ptr<Volume> inner, const Directory& store, std::uint64_t sequence,
                   const LogPlace& log, bool writable);
  ~GenerationVolume() override;

  std::unique_ptr<Backend> open_level(const LevelSpec& level) override;
  std::uint64_t scratch_bytes() const noexcept override { return inner_->scratch_bytes(); }
  std::uint64_t scratch_bytes_with(std::span<const FutureLevel> levels) const override {
    return inner_->scratch_bytes_with(levels);
  }
  void begin_version(std::uint64_t sequence, std::span<const std::uint64_t> held) override;

  /// Whether a record is enough for the next version: all that the levels have written since the
  /// last commit is in the log of the committed version, which is not nearly full. REQUIRES for
  /// this function and the next two: all levels were synced.
  bool is_small_commit() const;
  /// Appends the pieces' bytes and a record of all changed blocks, and syncs the log if `durable`.
  /// Returns the log as the next version needs it. Errors: kIo, kNoSpace.
  LogPlace commit_changes(const LogPlace& before,
                          std::span<const std::span<const std::byte>> pieces,
                          std::vector<ChangedRecords> records, bool durable);
  /// The log of a version that has a file of its own, synced if `durable`. No log if no block is in
  /// it.
  LogPlace finish_log(bool durable);
  /// Nothing that was written since the last commit counts. REQUIRES: no level is open.
  void roll_back();

 private:
  friend class GenerationLevel;

  ChangeLog& log_at(BlockPlace place) { return *logs_[place & 1]; }
  /// Whether no version names the bytes there.
  bool is_new(BlockPlace place) {
    return is_in_log(place) && log_offset(place) >= log_at(place).committed();
  }
  /// Whether a new log has begun since the last commit, and blocks are in the former one.
  bool has_former() const { return logs_[1 - current_] != nullptr; }
  bool is_in_former(BlockPlace place) const {
    return is_in_log(place) && has_former() && (place & 1) != current_;
  }
  std::uint64_t most_bytes() const;
  /// Whether the log is to end with the next version that has a file of its own. What is left until
  /// most_bytes() is for the commit of that version.
  bool is_nearly_full(const ChangeLog& log) const { return log.end() >= most_bytes() / 8 * 7; }
  /// Whether nobody can read a version before the newest one. One answer for a commit.
  bool is_unread();
  BlockPlace append(std::span<const std::byte> bytes);

  std::unique_ptr<Volume> inner_;
  const Directory& store_;
  std::uint64_t sequence_;
  bool is_described_;                     ///< the committed version has a file of its own
  std::optional<bool> is_unread_;         ///< the answer for this commit
  std::uint64_t most_log_bytes_ = 0;      ///< half of the bytes of all levels
  std::vector<GenerationLevel*> levels_;  ///< those that are open
  std::mutex making_;                     ///< of a new log
  std::array<std::unique_ptr<ChangeLog>, 2> logs_;
  unsigned current_ = 0;  ///< the position of the log to which blocks are appended
};

PLAIT_END_NAMESPACE
