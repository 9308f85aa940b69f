// maintenance/compare_attribute.h: compares a copy of an attribute with its source.
#pragma once

#include <optional>

#include "plait/detail/namespace.h"
#include "plait/extend/rounding.h"
#include "plait/progress.h"
#include "plait/store.h"

PLAIT_BEGIN_NAMESPACE

/// Reads all levels of an attribute and of its copy, in the same store or in another one with the
/// same base mesh, and compares every record. Without a bound, all bytes have to be equal. With a
/// bound, base records have to be equal, and the error of each other record must be within the
/// bound; errors are computed in long double. `progress` counts raw bytes. REQUIRES: both have the
/// same type and levels. Errors: kCorruption with the first slot that is not right; kCancelled;
/// those of Rounder, and of reading blocks.
void compare_attribute(const Store& store, AttributeId attribute, const Store& of_copy,
                       AttributeId copy, const std::optional<ErrorBound>& bound = {},
                       const ProgressCallback& progress = {});

PLAIT_END_NAMESPACE
