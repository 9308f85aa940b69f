// plait/level_pipelines.h: the pipelines of an attribute, which may differ from level to level.
//
// One text names them all: a pipeline, and others for ranges of levels.
//
//   PIPELINES = PIPELINE { ";@" LEVELS "=" PIPELINE }      LEVELS = FIRST ["-" [LAST]]
//
//   hierarchy,bitpack                                 for all levels
//   hierarchy,bitpack;@1-3=shuffle,zstd:19            another one for levels 1 to 3
//   lz4;@4=zstd:1;@6-=zstd:9                          for level 4; for level 6 and finer ones
//
// The ranges are in ascending order and do not overlap. Wherever an attribute is given a pipeline,
// such a text may stand: StoreOptions::pipeline, Store::set_pipeline(), recode_attribute(), and the
// functions of a backend that BackendRegistry::find() returns. A store records the text for levels
// that are added later (plait/attribute_levels.h tells those of the levels that there are). A level
// itself has one pipeline, so a pipeline contains no semicolon.
//
// Pinned by tests/engine/paging/level_pipelines_test.cpp.
#pragma once

#include <array>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "plait/edge_index.h"
#include "plait/namespace.h"

PLAIT_BEGIN_NAMESPACE

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
  /// The same pipeline for all levels.
  explicit LevelPipelines(std::string_view pipeline);
  /// Errors: kInvalidArgument for text that is not as above, in time that grows with its length.
  static LevelPipelines parse(std::string_view text);

  /// Gives these levels another pipeline.
  void set(const LevelRange& levels, std::string_view pipeline);
  /// REQUIRES: 0 <= level <= kMaxLevel.
  const std::string& of(int level) const { return of_level_[static_cast<std::size_t>(level)]; }
  /// The pipeline of levels that no range contains, and then those of the ranges.
  std::vector<std::string> all() const;
  /// With each pipeline changed by `change`.
  LevelPipelines changed(const std::function<std::string(std::string_view)>& change) const;
  /// Neighbouring levels with the same pipeline are one range, so equal objects have equal texts.
  std::string to_text() const;

 private:
  struct Range {
    LevelRange levels;
    const std::string* pipeline;
  };
  std::vector<Range> ranges() const;

  std::string general_;
  std::array<std::string, kMaxLevel + 1> of_level_;
};

PLAIT_END_NAMESPACE
