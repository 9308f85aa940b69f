// plait/backends/compression.h: how a user names the pipelines of a store: by a preset, by a
// pipeline, or by one of them for an attribute or for a range of levels. These are the values of
// the program's option --compress.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "plait/attribute.h"
#include "plait/level_pipelines.h"
#include "plait/namespace.h"

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
std::string preset_pipeline(std::string_view preset, const AttributeSchema& schema);

/// The pipeline for records that were rounded to multiples of `step` (plait/rounding.h):
/// `hierarchy` gets the step, `parallelogram` and `columns` become `lattice` and `lorenzo`,
/// `normals` becomes `hierarchy`, `predicted` goes, and other filters stay as they are. So does a
/// pipeline that has no filter. The pipelines of ranges of levels (plait/level_pipelines.h) are
/// changed likewise.
std::string pipeline_of_rounded(std::string_view pipeline, double step);

/// The pipelines of all attributes and levels of a store.
///
///   Compression compression;
///   compression.add("default");
///   compression.add("normal=shuffle,zstd:3");
///   compression.add("position@1-3=shuffle,zstd:19");
///   options.pipeline_of = [=](const auto& schema) { return compression.pipeline_of(schema); };
///
/// Of the texts that suit an attribute and a level, one that names the attribute goes before one
/// that does not, and then the smaller range of levels before the larger. A later text for the same
/// attribute and the same levels takes the place of the earlier one.
class Compression {
 public:
  /// `text` is a preset or a pipeline (plait/backends/pipeline.h), for all attributes and levels or
  /// for some of them: "[ATTRIBUTE][@LEVELS]=...", with levels such as 4, 1-3 or 6-. Errors:
  /// kInvalidArgument for an empty text or name, for levels that cannot be, and if the range of
  /// levels and an earlier one of the same attribute overlap, but neither contains the other.
  void add(std::string_view text);
  bool empty() const { return choices_.empty(); }
  /// The pipelines of an attribute, as plait/level_pipelines.h writes them; where no text suits,
  /// the preset "default". Errors: as preset_pipeline().
  std::string pipeline_of(const AttributeSchema& schema) const;
  /// Errors: kInvalidArgument for a text about levels of which a store with levels base_level + 1
  /// to `finest_level` has none, or that ends beyond `finest_level`.
  void check_levels(int base_level, int finest_level) const;

 private:
  struct Choice {
    std::string attribute;  ///< empty: all
    LevelRange levels;
    std::string pipeline;  ///< or a preset
  };
  void put(Choice choice);
  std::vector<Choice> choices_;  ///< each goes before those that come earlier
};

PLAIT_END_NAMESPACE
