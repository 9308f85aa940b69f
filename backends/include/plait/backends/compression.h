// plait/backends/compression.h: how a user names the pipelines of a store: by a preset, by a
// pipeline, or by one of them for each attribute. These are the values of the program's option
// --compress.
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "plait/attribute.h"
#include "plait/namespace.h"

PLAIT_BEGIN_NAMESPACE

/// A choice of pipelines with a name.
struct CompressionPreset {
  std::string_view name;
  std::string_view summary;  ///< one line for --help
};
/// fast, default, small, none.
const std::vector<CompressionPreset>& compression_presets();

/// The pipeline of a preset for records of this type: records of 1 to 4 floats are predicted from
/// coarser levels, others are not. Errors: kInvalidArgument for an unknown preset; the message
/// lists the known ones.
std::string preset_pipeline(std::string_view preset, const AttributeSchema& schema);

/// The pipeline for records that were rounded to multiples of `step` (plait/rounding.h):
/// `hierarchy` gets the step, `parallelogram` becomes `lattice` and `lorenzo`, `normals` becomes
/// `hierarchy`, `predicted` goes, and other filters stay as they are. So does a pipeline that has
/// no filter.
std::string pipeline_of_rounded(std::string_view pipeline, double step);

/// The pipelines of all attributes of a store.
///
///   Compression compression;
///   compression.add("default");
///   compression.add("normal=shuffle,zstd:3");
///   options.pipeline_of = [=](const auto& schema) { return compression.pipeline_of(schema); };
class Compression {
 public:
  /// `text` is a preset, a pipeline (plait/backends/pipeline.h), or one of them for one attribute:
  /// "ATTRIBUTE=...". A later text for the same attributes takes the place of the earlier one.
  /// Errors: kInvalidArgument for an empty text or name.
  void add(std::string_view text);
  bool empty() const { return general_.empty() && of_attribute_.empty(); }
  /// The pipeline of an attribute; of those that no text names, the preset "default". Errors: as
  /// preset_pipeline().
  std::string pipeline_of(const AttributeSchema& schema) const;

 private:
  std::string general_;
  std::map<std::string, std::string, std::less<>> of_attribute_;
};

PLAIT_END_NAMESPACE
