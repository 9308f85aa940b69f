// tools/tune/block_trial.h: encodes and decodes blocks by a pipeline, as the backend `compressed`
// does it, and measures both.
#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "plait/backends/pipeline.h"
#include "tune/figures.h"
#include "tune/sample.h"
#include "tune/store_bytes.h"

namespace plait::tune {

/// Codecs and working memory, which all trials share: they are as warm for one as for another. For
/// one thread.
class BlockTrials {
 public:
  /// `registry` and `bytes` outlive this object.
  BlockTrials(const PipelineRegistry& registry, StoreBytes& bytes);
  ~BlockTrials();
  BlockTrials(const BlockTrials&) = delete;
  BlockTrials& operator=(const BlockTrials&) = delete;

  /// Whether blocks of the part's level are encoded from other blocks with this pipeline. Errors:
  /// those of PipelineRegistry::make.
  bool needs_other_blocks(const BlockGrid& grid, const SamplePart& part,
                          const std::string& pipeline);

  /// Whether a scheme makes one of the part's blocks again, which the pipeline's stage `predicted`
  /// finds. Errors: as needs_other_blocks().
  bool is_made(const BlockGrid& grid, const SamplePart& part, const std::string& pipeline);

  /// All blocks of `grid` that the part consists of. Adds a visit to `outcome`. Errors: kCorruption
  /// if other bytes come back; those of reading the store and of PipelineRegistry::make.
  void measure(const BlockGrid& grid, const SamplePart& part, const std::string& pipeline,
               Outcome& outcome);

 private:
  struct Filtered;
  struct Block;
  Filtered& filters_of(const BlockGrid& grid, const SamplePart& part, const std::string& pipeline);
  Codec& codec_of(const std::string& pipeline);
  void gather_context(const BlockGrid& grid, const Filtered& filtered, std::uint64_t block);
  void run(Filtered& filtered, Codec& codec, const Block& block, Outcome& outcome);

  const PipelineRegistry& registry_;
  StoreBytes& bytes_;
  std::map<std::string, std::unique_ptr<Codec>> codecs_;  ///< by the text behind the comma
  std::map<std::string, std::unique_ptr<Filtered>> filters_;
  std::vector<std::vector<std::byte>> buffers_;
  std::vector<std::byte> encoded_, scratch_;
  std::vector<std::span<const std::byte>> context_;
};

}  // namespace plait::tune
