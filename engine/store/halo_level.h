// A level of which one process computes some slots for itself: those of its part and of the halo
// around it. All other slots are those of another level.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "plait/detail/level_file.h"
#include "plait/detail/namespace.h"
#include "plait/extend/backend.h"
#include "plait/extend/directory.h"
#include "plait/extend/file.h"
#include "plait/extend/topology.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Slots of `edges` are in a file of their own, without gaps, with a checksum for each run of them.
/// They are those of the other level until they are written; what is written to other slots is
/// lost. The destructor removes the file.
class HaloLevel final : public Backend {
 public:
  /// Makes the file `name`. `directory` and `frozen` must outlive this object. Errors: kIo,
  /// kNoSpace.
  HaloLevel(const Directory& directory, std::string name, const LevelFile& frozen,
            std::span<const EdgeId> edges);
  ~HaloLevel() override;
  HaloLevel(const HaloLevel&) = delete;
  HaloLevel& operator=(const HaloLevel&) = delete;

  /// [block] whether slots of the block are those of the other level.
  std::vector<bool> partly_written() const;

  void read(BlockRange blocks, std::span<std::byte> into) override;
  void write(BlockRange blocks, std::span<const std::byte> from) override;
  void advise(BlockRange, Advice) noexcept override {}
  void sync(bool) override {}
  std::uint64_t stored_bytes() const override { return file_.size(); }

 private:
  /// Slots without gaps in one block.
  struct Run {
    std::uint64_t block = 0, in_block = 0, bytes = 0;  ///< `in_block`: the offset there
    std::uint64_t in_file = 0, checksum = 0;
    bool is_written = false;
  };
  std::span<Run> runs_of(std::uint64_t block);
  bool fills_block(std::span<const Run> runs) const;

  const Directory& directory_;
  std::string name_;
  const LevelFile& frozen_;
  File file_;
  std::vector<Run> runs_;  ///< in the order of blocks
};

PLAIT_END_NAMESPACE
