// A volume around one whose backends overwrite in place. It stores a level in several files, the
// level's generations: a whole one, which has room for all blocks, and sparse ones, each with the
// blocks that one version wrote anew. The block table says which file has a block.
//
// Invariants
//  1. No byte of a block of the committed version changes in the file that the version names, nor a
//     byte of a block of an older version that a reader has open.
//  2. From the first write of a block of the committed version on, all that is written goes to a
//     new file. A crash leaves it as a left-over, and the other files as they were.
//  3. A commit takes the sparse files together (a fold) when their blocks are half of the level's.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "plait/extend/backend.h"
#include "plait/extend/directory.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

class GenerationLevel;

class GenerationVolume final : public Volume {
 public:
  /// `store` outlives this object. Version `sequence` is the committed one. Readers may have the
  /// older versions `held` open.
  GenerationVolume(std::unique_ptr<Volume> inner, const Directory& store, std::uint64_t sequence,
                   std::span<const std::uint64_t> held);
  ~GenerationVolume() override;

  /// Opens all files that the level's table names; `level.name` is that of the whole one.
  std::unique_ptr<Backend> open_level(const LevelSpec& level) override;
  std::uint64_t scratch_bytes() const noexcept override { return inner_->scratch_bytes(); }
  std::uint64_t scratch_bytes_with(std::span<const FutureLevel> levels) const override {
    return inner_->scratch_bytes_with(levels);
  }
  void begin_version(std::uint64_t sequence, std::span<const std::uint64_t> held) override;

 private:
  friend class GenerationLevel;

  std::unique_ptr<Volume> inner_;
  const Directory& store_;
  std::uint64_t sequence_;
  bool has_held_;                         ///< readers may have older versions open
  std::vector<GenerationLevel*> levels_;  ///< those that are open
};

PLAIT_END_NAMESPACE
