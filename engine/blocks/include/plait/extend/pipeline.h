// plait/extend/pipeline.h: how the blocks of a level are encoded, as a value: filters, one after
// another, then a codec. This is the only place that reads or writes the text of a pipeline.
//
//   PIPELINES = PIPELINE { ";@" LEVELS "=" PIPELINE }      LEVELS = FIRST ["-" [LAST]]
//   PIPELINE  = [ STAGE { "+" STAGE } "," ] STAGE          STAGE  = NAME [":" OPTIONS]
//
//   lz4                                            a codec
//   x-delta:stride=3+shuffle,zstd:1                two filters and a codec
//   predicted+hierarchy,bitpack                    the stage `predicted`, a filter and a codec
//   hierarchy,bitpack;@1-3=lz4;@6-=zstd:19         others for levels 1 to 3, and from 6 on
//
// All is printable ASCII; a name has characters of [A-Za-z0-9_-]. The first comma ends the filters:
// a codec's options may have commas if a filter, such as "none", comes before. A filter's have no
// comma and no plus sign, and none a semicolon. Ranges of levels ascend and do not overlap.
//
// The first stage may be `predicted`, with a recipe as its options: it stores blocks that are made
// again in no bytes (plait/extend/block_maker.h). The codec "none" copies; the filter "none" stands
// for no filter. A PipelineRegistry has the filters and codecs that a program can use.
//
// Pinned by tests/engine/blocks/pipeline_test.cpp.
#pragma once

#include <concepts>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "plait/detail/namespace.h"
#include "plait/extend/topology.h"

PLAIT_BEGIN_NAMESPACE

/// The name of the stage that is not a filter.
inline constexpr std::string_view kPredictedStage = "predicted";

/// Whether a filter or a codec may have this name.
bool is_stage_name(std::string_view name) noexcept;

/// A filter or a codec of a pipeline.
struct PipelineStage {
  std::string name = {}, options = {};

  std::string to_text() const;
  friend bool operator==(const PipelineStage&, const PipelineStage&) = default;
};

/// The pipeline of one level. A value: any thread may read it.
struct Pipeline {
  /// "none".
  Pipeline() = default;
  /// Reads a text as above. Errors: kInvalidArgument, in time that grows with its length.
  template <std::convertible_to<std::string_view> Text>
  Pipeline(const Text& text) : Pipeline(parse(text)) {}

  std::string to_text() const;

  /// Nothing without the stage `predicted`; empty if the stage has no recipe.
  std::optional<std::string> recipe = {};
  std::vector<PipelineStage> filters = {};
  PipelineStage codec = {"none", {}};

  bool has_predicted_stage() const noexcept { return recipe.has_value(); }
  /// The same pipeline with another recipe, if it has the stage.
  Pipeline with_recipe(std::string_view other) const;
  Pipeline without_predicted_stage() const;

  friend bool operator==(const Pipeline&, const Pipeline&) = default;

 private:
  static Pipeline parse(std::string_view text);
};

/// Levels `first` to `last`, both included. 0 <= first <= last <= kMaxLevel.
struct LevelRange {
  int first = 0, last = kMaxLevel;

  /// "4", "1-3", or "6-" for level 6 and all finer ones. Errors: kInvalidArgument.
  static LevelRange parse(std::string_view text);
  std::string to_text() const;
  bool contains(const LevelRange& other) const noexcept {
    return first <= other.first && other.last <= last;
  }
  bool meets(const LevelRange& other) const noexcept {
    return first <= other.last && other.first <= last;
  }
  friend bool operator==(const LevelRange&, const LevelRange&) = default;
};

/// The pipeline of each level of an attribute. A value: any thread may read it.
class LevelPipelines {
 public:
  /// "none" for all levels.
  LevelPipelines() = default;
  /// The same pipeline for all levels.
  LevelPipelines(Pipeline pipeline) : general_(std::move(pipeline)) {}
  /// Reads a text as above. Errors: kInvalidArgument, in time that grows with its length.
  template <std::convertible_to<std::string_view> Text>
  LevelPipelines(const Text& text) : LevelPipelines(parse(text)) {}

  /// Gives these levels another pipeline.
  void set(const LevelRange& levels, const Pipeline& pipeline);
  /// REQUIRES: 0 <= level <= kMaxLevel.
  const Pipeline& of(int level) const;
  /// Calls `change(pipeline)` for the pipeline of levels that no range contains, and then for those
  /// of the ranges. It may change the pipeline.
  template <class Change>
  void for_each(Change&& change) {
    change(general_);
    for (auto& [level, pipeline] : others_) change(pipeline);
    normalize();
  }
  template <class Use>
  void for_each(Use&& use) const {
    use(general_);
    for (const auto& [level, pipeline] : others_) use(pipeline);
  }
  /// Neighbouring levels with the same pipeline are one range, so equal objects have equal texts.
  std::string to_text() const;

  friend bool operator==(const LevelPipelines&, const LevelPipelines&) = default;

 private:
  static LevelPipelines parse(std::string_view text);
  void normalize();

  Pipeline general_;
  std::map<int, Pipeline> others_;  ///< of the levels whose pipeline is not general_
};

PLAIT_END_NAMESPACE
