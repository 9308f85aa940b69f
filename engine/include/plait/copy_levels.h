// plait/copy_levels.h: the same content in another backend, pipeline or block size.
#pragma once

#include <cstdint>
#include <functional>

#include "plait/namespace.h"
#include "plait/rounding.h"
#include "plait/store.h"

PLAIT_BEGIN_NAMESPACE

/// Copies all levels of an attribute, coarser ones first, to an attribute that has no level, of the
/// same store or of another one with the same base mesh. `proceed` gets the bytes of the level that
/// were copied since its last call; if it returns false, the call ends. With a `rounder`, the copy
/// gets rounded records, except base records. If `copy` is derived (plait/derivation.h), the call
/// only adds the levels, and compares the records with those of `attribute`. Errors: kCancelled;
/// those of reading and writing blocks; kInvalidArgument for a derived copy with other records, and
/// for one with a rounder.
void copy_attribute(Store& from, AttributeId attribute, Store& to, AttributeId copy,
                    const std::function<bool(std::uint64_t copied)>& proceed = {},
                    Rounder* rounder = nullptr);

/// Copies all attributes and levels of `from` into `to`, level by level in slot order, and leaves
/// the commit to the caller. Rounds the attributes that `bounds` names; attributes that it names
/// and `from` has not are ignored. What is derived in `from` is derived in `to`, unless
/// to.options().pipeline_of says otherwise; what is derived from a rounded attribute is not
/// compared. Memory is bounded by the budgets of the two stores.
/// REQUIRES: `to` was created with from.base() and has no attribute. Errors: also those of Rounder.
void copy_levels(Store& from, Store& to,
                 const std::function<bool(std::uint64_t done, std::uint64_t total)>& proceed = {},
                 const ErrorBounds& bounds = {});

PLAIT_END_NAMESPACE
