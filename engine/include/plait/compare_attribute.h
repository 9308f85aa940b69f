// plait/compare_attribute.h: whether a copy of an attribute is what was copied.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>

#include "plait/namespace.h"
#include "plait/rounding.h"
#include "plait/store.h"

PLAIT_BEGIN_NAMESPACE

/// Reads all levels of an attribute and of its copy, in the same store or in another one with the
/// same base mesh, and compares every record. Without a bound, all bytes have to be equal. With a
/// bound, base records have to be equal, and the error of each other record must be within the
/// bound; errors are computed in long double. `proceed` gets the bytes that were compared since its
/// last call; if it returns false, the call ends. REQUIRES: both have the same type and levels.
/// Errors: kCorruption with the first slot that is not right; kCancelled; those of Rounder, and of
/// reading blocks.
void compare_attribute(const Store& store, AttributeId attribute, const Store& of_copy,
                       AttributeId copy, const std::optional<ErrorBound>& bound = {},
                       const std::function<bool(std::uint64_t compared)>& proceed = {});

PLAIT_END_NAMESPACE
