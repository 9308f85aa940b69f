// store/attribute_levels.h: the levels of an attribute, taken together.
#pragma once

#include <cstdint>

#include "plait/detail/namespace.h"
#include "plait/extend/pipeline.h"
#include "plait/store.h"

PLAIT_BEGIN_NAMESPACE

/// The pipelines of the levels that the attribute has: that of the finest level
/// for all levels but coarser ones that have others. Of an attribute without levels, those of the
/// store's options.
LevelPipelines pipelines_of_levels(const Store& store, AttributeId attribute);
/// The pipelines that levels have in the end which are added later, as Store::set_pipeline() or the
/// store's options name them.
const LevelPipelines& named_pipelines(const Store& store, AttributeId attribute);
/// Bytes of the records of all levels of the attribute, as if no block were encoded.
std::uint64_t bytes_of_levels(const Store& store, AttributeId attribute);

PLAIT_END_NAMESPACE
