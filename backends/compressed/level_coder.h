// backends/compressed/level_coder.h: how the blocks of one level are encoded and decoded, or made
// again: the level's filters and maker, and the blocks of other levels that these need.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "compressed/block_coder.h"
#include "compressed/coder_pool.h"
#include "compressed/level_context.h"
#include "plait/extend/backend.h"
#include "plait/extend/pipeline_registry.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// What coders of a level with this pipeline are made for.
Coding coding_of(const Pipeline& pipeline, const OpenPipeline& open);

/// Immutable; any number of threads may use it, each with a BlockCoder of its own. `given` is the
/// context of a transfer (Transfer::context): that of context() or that of read_context().
class LevelCoder {
 public:
  using Given = std::span<const std::span<const std::byte>>;
  using Needed = std::span<ContextBlock, kMostContextBlocks>;

  /// The other two arguments are those of LevelContext.
  LevelCoder(const LevelSpec& level, OpenPipeline pipeline,
             std::span<const BlockTable* const> open_tables);

  /// The coders that blocks of the level need.
  const Coding& coding() const noexcept { return coding_; }
  /// As Backend::context().
  std::size_t context(std::uint64_t block, Needed needed) const noexcept;
  /// As Backend::read_context(), for a block that is stored with this encoding.
  std::size_t read_context(std::uint64_t block, BlockEncoding encoding,
                           Needed needed) const noexcept;
  /// Whether blocks with this encoding need the base records of this attribute.
  bool needs_base_records(BlockEncoding encoding, std::uint32_t attribute) const noexcept;

  /// Whether the level's maker makes these bytes.
  bool makes(std::uint64_t block, Given given, std::span<const std::byte> raw) const;
  /// Errors: kNotSupported if the level has no maker; the message says why.
  void make(std::uint64_t block, Given given, std::span<std::byte> raw) const;

  EncodedBlock encode(BlockCoder& coder, std::uint64_t block, Given given,
                      std::span<const std::byte> raw) const;
  /// Errors: as BlockCoder::decode(), without the names of file and block.
  void decode(BlockCoder& coder, std::uint64_t block, Given given,
              std::span<const std::byte> stored, std::span<std::byte> raw) const;

 private:
  std::size_t sources_of(std::uint64_t block, Needed needed) const noexcept;
  Given for_maker(std::uint64_t block, Given given) const;
  Given for_filters(std::uint64_t block, Given given) const;

  std::filesystem::path path_;  ///< of the level, for messages
  Coding coding_;
  Filters filters_;
  LevelContext context_;  ///< refers to filters_
  std::shared_ptr<const BlockMaker> maker_;
  std::string why_no_maker_;
};

PLAIT_END_NAMESPACE
