// plait/recode_attribute.h: encodes an attribute of a store anew, with other pipelines.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "plait/namespace.h"
#include "plait/rounding.h"
#include "plait/store.h"

PLAIT_BEGIN_NAMESPACE

/// How recode_attribute() works.
struct RecodeOptions {
  /// Rounds the records, by this much at most. Without a bound they do not change.
  std::optional<ErrorBound> bound = {};
  /// Before the old levels go, decodes the new ones and compares every record
  /// (compare_attribute()). This takes as much reading again.
  bool verify = false;
  /// Called often with the bytes done and to do; if it returns false, the call ends.
  std::function<bool(std::uint64_t done, std::uint64_t total)> proceed = {};
};

/// Copies all levels of the attribute, coarser ones first, to new files with these pipelines
/// (plait/level_pipelines.h), and removes the old levels with the next commit. Until the commit,
/// both take disk space. With "derived" the attribute is computed when it is read, and with other
/// pipelines a derived one is stored. After an error the attribute is as before.
/// Errors: as Store::set_pipeline(); as copy_attribute(); kCancelled; kBadState if other levels
/// were encoded from those of the attribute; those of Rounder, and of reading and writing blocks;
/// kCorruption from `verify`.
void recode_attribute(Store& store, AttributeId attribute, const std::string& pipelines,
                      const RecodeOptions& options = {});

PLAIT_END_NAMESPACE
