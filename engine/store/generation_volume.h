// A volume around one that overwrites in place: a level of which blocks of the committed version
// are written anew gets a new file, its next generation, beside the one that the version has.
//
// Invariants
//  1. No byte of a block of the committed version changes in the file that the version names.
//  2. From the first write of such a block on, all that is written goes to the new file.
//  3. A block is read from the new file if it was written there, else from the old one.
//  4. sync() copies what was not written anew, so that the new file is whole when the version names
//     it. A crash before that leaves the old file, and the new one as a left-over.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "plait/backend.h"
#include "plait/directory.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

class GenerationLevel;

class GenerationVolume final : public Volume {
 public:
  /// `store` outlives this object; version `sequence` is the committed one.
  GenerationVolume(std::unique_ptr<Volume> inner, const Directory& store, std::uint64_t sequence);
  ~GenerationVolume() override;

  /// Errors of a write beside those of the inner volume's: kNoSpace, naming the level, the bytes
  /// that its new file needs and those that are free, before anything is written.
  std::unique_ptr<Backend> open_level(const LevelSpec& level) override;
  std::uint64_t scratch_bytes() const noexcept override { return inner_->scratch_bytes(); }
  void begin_version(std::uint64_t sequence, std::span<const std::uint64_t> held) override;

  struct Level {
    std::uint32_t attribute;
    int level;
  };
  /// The levels whose new files the version that is being committed has.
  std::vector<Level> renewed_levels() const;

 private:
  friend class GenerationLevel;

  std::unique_ptr<Volume> inner_;
  const Directory& store_;
  std::uint64_t sequence_;
  std::vector<GenerationLevel*> levels_;  ///< those that are open
};

/// Refuses a new file of `needed_bytes` where fewer are free. Errors: kNoSpace.
void check_free_space(const LevelSpec& level, std::uint64_t needed_bytes, std::uint64_t free_bytes);

PLAIT_END_NAMESPACE
