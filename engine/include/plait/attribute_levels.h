// plait/attribute_levels.h: the levels of an attribute, taken together.
#pragma once

#include <cstdint>
#include <string>

#include "plait/namespace.h"
#include "plait/store.h"

PLAIT_BEGIN_NAMESPACE

/// The pipelines of the levels that the attribute has, as plait/level_pipelines.h writes them: that
/// of the finest level, and those of ranges of coarser levels that have others. Of an attribute
/// without levels, those of the store's options.
std::string pipelines_of_levels(const Store& store, AttributeId attribute);
/// Bytes of the records of all levels of the attribute, as if no block were encoded.
std::uint64_t bytes_of_levels(const Store& store, AttributeId attribute);

PLAIT_END_NAMESPACE
