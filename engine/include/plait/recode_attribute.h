// plait/recode_attribute.h: encodes an attribute of a store anew, with another pipeline.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "plait/namespace.h"
#include "plait/rounding.h"
#include "plait/store.h"

PLAIT_BEGIN_NAMESPACE

/// Copies all levels of the attribute, coarser ones first, to new files with this pipeline, and
/// removes the old levels with the next commit. The records do not change, unless `bound` says how
/// far they may be rounded. Until the commit, both
/// take disk space. `proceed` is called often with the bytes done and to do; if it returns false,
/// the call ends. After an error the attribute is as before.
/// Errors: as Store::set_pipeline(); kCancelled; kBadState if other levels were encoded from those
/// of the attribute; those of Rounder, and of reading and writing blocks.
void recode_attribute(Store& store, AttributeId attribute, const std::string& pipeline,
                      const std::function<bool(std::uint64_t, std::uint64_t)>& proceed = {},
                      const std::optional<ErrorBound>& bound = {});

PLAIT_END_NAMESPACE
