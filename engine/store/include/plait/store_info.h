// plait/store_info.h: figures of a store: Store::info().
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "plait/detail/namespace.h"
#include "plait/extend/backend.h"
#include "plait/extend/block_table.h"
#include "plait/extend/rounding.h"
#include "plait/extend/session.h"
#include "plait/store.h"

PLAIT_BEGIN_NAMESPACE

/// A value: it does not change with the store.
struct StoreInfo {
  StoreUuid uuid = {};  ///< copies of a store have others
  BackendTraits backend = {};
  /// What the store has read, written and kept in frames since it was opened.
  PagingStatistics paging = {};
  /// Bytes of all levels and base records, and of the base mesh file: on disk, or in memory if the
  /// store has no path.
  std::uint64_t stored_bytes = 0;
  /// [attribute] how the records of its levels were rounded; nothing if they were not.
  std::vector<std::optional<Rounding>> roundings = {};
};

PLAIT_END_NAMESPACE
