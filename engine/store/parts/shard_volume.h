// A volume around one whose levels are in one piece. It opens levels in shards for reading: it
// finds the shard of a block, opens the file of the shard when a block of it is read, and keeps few
// files open. Executors and the pager see only the level's blocks.
#pragma once

#include <cstddef>
#include <cstdint>
#include <list>
#include <memory>
#include <mutex>

#include "plait/extend/backend.h"
#include "plait/extend/block_table.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

class ShardLevel;

/// The file of one shard of one level.
struct OpenShard {
  const ShardLevel* level = nullptr;
  std::uint32_t shard = 0;
  LevelGeometry geometry;
  BlockTable table;
  std::unique_ptr<Backend> backend;
};

class ShardVolume final : public Volume {
 public:
  /// The most files that are open, beside those that a thread reads at this moment.
  static constexpr std::size_t kMostOpenFiles = 64;

  /// `shares_files`: as in VersionDescription; `traits` are those of the inner volume.
  ShardVolume(std::unique_ptr<Volume> inner, bool shares_files, const BackendTraits& traits);
  ~ShardVolume() override;

  /// Opens a level in shards for reading: files of its shards are opened when they are read. A
  /// level that is not in shards is that of one shard alone, which a part makes.
  std::unique_ptr<Backend> open_level(const LevelSpec& level) override;
  std::uint64_t scratch_bytes() const noexcept override { return inner_->scratch_bytes(); }
  std::uint64_t scratch_bytes_with(std::span<const FutureLevel> levels) const override {
    return inner_->scratch_bytes_with(levels);
  }

 private:
  friend class ShardLevel;

  /// The open file of a shard; opens it, and closes the one that was used least lately.
  std::shared_ptr<OpenShard> open(const ShardLevel& level, std::uint32_t shard);
  void close_files_of(const ShardLevel& level) noexcept;

  std::unique_ptr<Volume> inner_;
  bool shares_files_;
  BackendTraits traits_;
  std::mutex mutex_;
  std::list<std::shared_ptr<OpenShard>> open_;  ///< the one that was used last comes first
};

PLAIT_END_NAMESPACE
