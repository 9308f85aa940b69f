// plait/extend/pipeline_registry.h: the filters and codecs of which pipelines are made. They are
// registered by name, as backends are. A program adds its own to a copy of default_pipelines()
// (plait/registry.h), and opens stores with default_backends(copy).
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "plait/attribute.h"
#include "plait/detail/namespace.h"
#include "plait/extend/block_maker.h"
#include "plait/extend/codec.h"
#include "plait/extend/filter.h"
#include "plait/extend/pipeline.h"

PLAIT_BEGIN_NAMESPACE

/// A pipeline that is ready for the blocks of one level. Encoding applies filters.front() first,
/// decoding applies it last.
struct OpenPipeline {
  std::vector<std::unique_ptr<Filter>> filters;
  std::unique_ptr<Codec> codec;
  /// Of the stage `predicted`; nullptr without it, and if it makes no block of this level.
  std::shared_ptr<const BlockMaker> maker = {};
  std::string why_no_maker = {};  ///< why predicted blocks cannot be made, for messages
};

/// A codec: its name, and the function that makes one.
struct RegisteredCodec {
  std::string name = {};
  std::string summary = {};  ///< one line for --help, which also explains the options
  /// `options` are those of the stage. Throws kInvalidArgument for options that the codec does not
  /// take.
  std::function<std::unique_ptr<Codec>(std::string_view options)> make = {};
};

/// A filter: its name, and the function that makes one.
struct RegisteredFilter {
  std::string name = {};
  std::string summary = {};
  /// As in RegisteredCodec. Returns nullptr if the filter would change nothing for records of this
  /// type. Throws kNotSupported for records that the filter cannot transform.
  std::function<std::unique_ptr<Filter>(std::string_view options, const FilterLevel& level)> make =
      {};
};

/// Finds codecs and filters by name. Only one thread may call add(); all other calls are safe from
/// any number of threads.
class PipelineRegistry {
 public:
  /// Errors: kInvalidArgument for a name that is taken or that no stage can have
  /// (plait/extend/pipeline.h), and for an empty `make`.
  void add(RegisteredCodec codec);
  void add(RegisteredFilter filter);

  /// What the stage `predicted` makes. nullptr: nothing.
  void set_block_makers(std::shared_ptr<const BlockMakers> makers) { makers_ = std::move(makers); }
  const BlockMakers* block_makers() const { return makers_.get(); }

  std::vector<std::string> codec_names() const;
  std::vector<std::string> filter_names() const;

  /// Errors: kNotSupported for a name that is not registered (the message lists the known names),
  /// for records that a filter cannot transform, and if a filter after the first one needs other
  /// blocks or keeps a note; kInvalidArgument for options that are refused.
  OpenPipeline open(const Pipeline& pipeline, const FilterLevel& level) const;
  /// Errors: as open().
  std::unique_ptr<Codec> make_codec(const PipelineStage& codec) const;

  /// Whether blocks of such records are encoded, or made, from other blocks, so that levels must be
  /// written one after another, coarser ones first. Errors: as open().
  bool needs_other_blocks(const Pipeline& pipeline, const AttributeSchema& schema) const;
  /// The pipeline for such levels: a stage `predicted` gets its recipe, or goes if the levels have
  /// none (plait/extend/block_maker.h).
  Pipeline planned(const Pipeline& pipeline, PlannedLevels levels) const;

 private:
  std::map<std::string, RegisteredCodec, std::less<>> codecs_;
  std::map<std::string, RegisteredFilter, std::less<>> filters_;
  std::shared_ptr<const BlockMakers> makers_;
};

PLAIT_END_NAMESPACE
