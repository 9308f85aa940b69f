// A scratch store with the attributes of a damaged store that follow from its base mesh.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "plait/partial_output.h"
#include "plait/repair.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

class RecomputedStore {
 public:
  /// The arguments outlive this object.
  RecomputedStore(const StoreCheck& check, const RepairOptions& options,
                  const BackendRegistry& backends, PartialDirectory& scratch,
                  const PlanRecomputation& recompute);

  /// Why this attribute cannot be computed again; empty if it can.
  std::string refusal(std::string_view attribute) const {
    return recomputation_.refusal(attribute);
  }

  /// The scratch store. The first call makes it. REQUIRES: an attribute without refusal. Errors:
  /// those of Store::create and of the recomputation; kInvalidArgument if it makes other
  /// attributes.
  Store& made();

 private:
  /// The rest of the repair reads all blocks of the attributes without refusal.
  void check_attributes(const Store& made) const;

  const StoreCheck& check_;
  const RepairOptions& options_;
  const BackendRegistry& backends_;
  PartialDirectory& scratch_;
  Recomputation recomputation_;
  std::optional<Store> made_;
};

PLAIT_END_NAMESPACE
