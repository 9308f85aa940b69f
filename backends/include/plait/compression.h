// plait/compression.h: how a user names the pipelines of a store: by a preset, by a
// pipeline, or by one of them for an attribute or for a range of levels. These are the values of
// the program's option --compress.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "plait/attribute.h"
#include "plait/detail/namespace.h"
#include "plait/extend/pipeline.h"

PLAIT_BEGIN_NAMESPACE

/// A choice of pipelines with a name.
struct CompressionPreset {
  std::string_view name;
  std::string_view summary;  ///< one line for --help
};
/// fast, default, small, none.
const std::vector<CompressionPreset>& compression_presets();

/// The pipeline of a preset for records of this type: `default` and `small` predict records of 1 to
/// 4 floats from coarser levels, `fast` predicts them inside their slots. Errors: kInvalidArgument
/// for an unknown preset; the message lists the known ones.
Pipeline preset_pipeline(std::string_view preset, const AttributeSchema& schema);

/// The pipeline for records that were rounded to multiples of `step` (plait/extend/rounding.h):
/// `hierarchy` gets the step, `lattice` is put before `columns`, `hierarchy` replaces `normals`,
/// `predicted` is removed, and other filters stay. A pipeline without filters does not change.
LevelPipelines pipeline_of_rounded(LevelPipelines pipelines, double step);

/// The pipelines of all attributes and levels of a store.
///
///   Compression compression;
///   compression.add("default");
///   compression.add("normal=shuffle,zstd:3");
///   compression.add("position@1-3=shuffle,zstd:19");
///   options.pipeline_of = [=](const auto& schema) { return compression.pipeline_of(schema); };
///
/// The most specific text wins: one that names the attribute, then the one with fewer levels, then
/// the latest.
class Compression {
 public:
  /// `text` is a preset or a pipeline (plait/extend/pipeline.h), for all attributes and levels or
  /// for some of them: "[ATTRIBUTE][@LEVELS]=...", with levels such as 4, 1-3 or 6-. Errors:
  /// kInvalidArgument for an empty text or name, for levels that no store has, and if the range of
  /// levels and an earlier one of the same attribute overlap, but neither contains the other; as
  /// Pipeline.
  void add(std::string_view text);
  bool empty() const { return choices_.empty(); }
  /// The pipelines of an attribute; where no text suits, the preset "default".
  LevelPipelines pipeline_of(const AttributeSchema& schema) const;
  /// Checks the texts against a store with levels base_level + 1 to `finest_level`. Errors:
  /// kInvalidArgument for a text that names none of these levels, or whose range ends beyond
  /// `finest_level`.
  void check_levels(int base_level, int finest_level) const;
  /// Checks the texts against the attributes of a store. Errors: kInvalidArgument for a text that
  /// names another attribute.
  void check_attributes(const std::vector<std::string>& names) const;

 private:
  struct Choice {
    std::string attribute;  ///< empty: all
    LevelRange levels;
    std::string preset;  ///< empty: `pipeline`
    Pipeline pipeline;
  };
  void put(Choice choice);
  std::vector<Choice> choices_;  ///< the most specific one last
};

PLAIT_END_NAMESPACE
