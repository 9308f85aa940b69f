// prune/compare_pruned.h: whether a store with depths has the bits of the store that it was pruned
// from.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "plait/detail/namespace.h"
#include "plait/progress.h"
#include "plait/store.h"

PLAIT_BEGIN_NAMESPACE

struct PrunedComparison {
  std::uint64_t slots = 0, records = 0;        ///< compared; base records count as records
  std::optional<std::string> difference = {};  ///< the first one, in words
};

/// Compares every record of every attribute of `pruned` with the one of the same address in
/// `whole`, slot by slot. Progress counts edges. Errors: kInvalidArgument for another base mesh, or
/// another order of its faces; kCancelled; those of reading blocks.
PrunedComparison compare_pruned(const Store& pruned, const Store& whole,
                                const ProgressCallback& progress = {});

PLAIT_END_NAMESPACE
