// plait/extend/copy_levels.h: the same content in another backend, pipeline or block size.
#pragma once

#include "plait/detail/namespace.h"
#include "plait/extend/rounding.h"
#include "plait/progress.h"
#include "plait/store.h"

PLAIT_BEGIN_NAMESPACE

/// Copies all levels of an attribute, coarser ones first, to an attribute that has no level, of the
/// same store or of another one with the same base mesh. `progress` counts raw bytes. With a
/// `rounder`, the copy gets rounded records, except base records. REQUIRES: attributes of `to` from
/// which blocks of the copy can be made (plait/extend/block_maker.h) are complete. Blocks get the
/// pipelines of the copy at once, so levels from which others are encoded cannot be changed any
/// more. With `changes_later` they can, and Store::finish_encoding() encodes them. Errors:
/// kCancelled; those of reading and writing blocks.
void copy_attribute(Store& from, AttributeId attribute, Store& to, AttributeId copy,
                    const ProgressCallback& progress = {}, Rounder* rounder = nullptr,
                    bool changes_later = false);

/// Copies texts and face attributes. REQUIRES: the same base mesh, and no face attribute in `to`.
void copy_notes(const Store& from, Store& to);

/// Copies all attributes and levels of `from`, its face attributes and texts into `to`, level by
/// level in slot order, and leaves the commit to the caller. Rounds the attributes that `bounds`
/// names, and ignores names that `from` does not have. Memory is bounded by the budgets of the two
/// stores. `progress` counts raw bytes. REQUIRES: `to` was created with from.base(), or with it and
/// depths (BaseMesh::with_depths), and has no attribute. Then the copy has what these depths leave.
/// Errors: kInvalidArgument for a face that is deeper than in `from`. Errors: also those of
/// Rounder.
void copy_levels(Store& from, Store& to, const ProgressCallback& progress = {},
                 const ErrorBounds& bounds = {}, bool changes_later = false);

PLAIT_END_NAMESPACE
