// plait/extend/recode_attribute.h: encodes an attribute of a store anew, with other pipelines.
#pragma once

#include <optional>

#include "plait/detail/namespace.h"
#include "plait/extend/rounding.h"
#include "plait/progress.h"
#include "plait/store.h"

PLAIT_BEGIN_NAMESPACE

/// How recode_attribute() works.
struct RecodeOptions {
  /// Rounds the records, by this much at most. Without a bound they do not change.
  std::optional<ErrorBound> bound = {};
  /// Before the old levels go, decodes the new ones and compares every record
  /// (compare_attribute()). This takes as much reading again.
  bool verify = false;
  ProgressCallback progress = {};  ///< counts raw bytes
};

/// Copies all levels of the attribute, coarser ones first, to new files with these pipelines
/// (plait/extend/pipeline.h), and removes the old levels with the next commit. Until the
/// commit, both take disk space. After an error the attribute is as before. Errors: before any work
/// those of Store::remove_attribute(), also kBadState while a walk over patches has blocks pinned;
/// as Store::set_pipeline(); as copy_attribute(); kCancelled; kBadState if other levels were
/// encoded from those of the attribute; those of Rounder, and of reading and writing blocks;
/// kCorruption from `verify`.
void recode_attribute(Store& store, AttributeId attribute, const LevelPipelines& pipelines,
                      const RecodeOptions& options = {});

PLAIT_END_NAMESPACE
