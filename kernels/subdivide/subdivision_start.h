// What a subdivision is asked before its first change: whether the store, the options, the
// pipelines and the budget allow all of it.
#pragma once

#include <cstdint>
#include <vector>

#include "plait/detail/namespace.h"
#include "plait/extend/provenance.h"
#include "plait/extend/store_access.h"
#include "plait/store.h"
#include "plait/subdivide.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// A store before a subdivision that nothing refuses. Threads: one.
class SubdivisionStart {
 public:
  /// Changes nothing. Errors: those that subdivide() has before its first change.
  SubdivisionStart(Store& store, const SubdivideOptions& options);

  /// The finest level of positions that the store has.
  int level() const noexcept { return level_; }
  /// The options with the executor and the number of threads that the work takes.
  const SubdivideOptions& options() const noexcept { return options_; }
  /// What the store records of the levels while the work makes them, and in the end.
  const Provenance& provenance() const noexcept { return provenance_; }

 private:
  void check_executor() const;
  /// Throws kBudget if the frames of the whole work do not fit.
  void check_budget() const;
  std::uint64_t frame_budget() const;
  /// The levels of normals and limit positions that the work makes.
  std::vector<StoreAccess::NewLevels> surface() const;
  bool is_fused() const { return options_.executor == ExecutorKind::kFused; }

  const Store& store_;
  SubdivideOptions options_;
  const AttributeId position_;
  const int level_;
  Provenance provenance_;
};

PLAIT_END_NAMESPACE
