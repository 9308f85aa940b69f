// backends/compressed/level_context.h: from which blocks of other levels the blocks of a level are
// encoded, and the seals that tell whether these blocks are still the same when a block is decoded
// (docs/format.md, "Level files").
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "compressed/block_coder.h"
#include "plait/extend/backend.h"
#include "plait/extend/block_table.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// What the filters of one level need beside the block that they transform: the blocks of other
/// levels that they name, and the base records of their attribute. An encoded block begins with the
/// seal of all that, so that a block whose context has changed since is an error, and does not
/// decode to other records.
///
/// Owns nothing: the filters and the base records outlive the object. The tables of the other
/// levels may end before it, if nobody calls seal() after that. Any number of threads may use an
/// object; while seal() runs, nobody changes the context blocks and their table entries
/// (Transfer::context).
class LevelContext {
 public:
  /// `open_tables`: of the levels that were opened before `level`. A level that is opened later is
  /// never context.
  LevelContext(const LevelSpec& level, const Filters& filters,
               std::span<const BlockTable* const> open_tables);
  LevelContext(const LevelContext&) = delete;
  LevelContext& operator=(const LevelContext&) = delete;

  /// As Backend::context().
  std::size_t blocks_for(std::uint64_t block,
                         std::span<ContextBlock, kMostContextBlocks> blocks) const noexcept;
  /// The attribute whose base records the filters read; kNoId if they read none.
  std::uint32_t base_attribute() const noexcept;

  /// The seal for `block`, whose context the caller has in `given`; nothing if the filters need no
  /// other blocks. Errors: kNotSupported if they need some, and `given` has another number of
  /// blocks, or their level was not open.
  std::optional<std::uint64_t> seal(std::uint64_t block,
                                    std::span<const std::span<const std::byte>> given) const;

 private:
  const BlockTable& table_of(std::uint64_t block, const ContextBlock& needed) const;

  std::filesystem::path path_;  ///< of the level, for messages
  const Filters& filters_;
  std::vector<const BlockTable*> tables_;  ///< of the levels that are context
  std::span<const std::byte> base_;
  mutable std::once_flag base_sealed_;
  mutable std::uint64_t base_seal_ = 0;  ///< valid once base_sealed_ is set
};

PLAIT_END_NAMESPACE
