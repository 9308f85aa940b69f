// The refinement that a store's provenance describes, made anew from its base mesh in a scratch
// store.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "plait/kernels/repair.h"
#include "plait/kernels/subdivide.h"
#include "plait/partial_output.h"
#include "plait/structure.h"

namespace plait {

class Recomputation {
 public:
  /// The arguments outlive this object.
  Recomputation(const StoreStructure& structure, const RepairOptions& options,
                const BackendRegistry& backends, PartialDirectory& scratch);

  /// Why this attribute cannot be computed anew; empty if it can.
  std::string refusal(std::string_view attribute) const;

  /// The levels made anew, once. REQUIRES: an attribute without refusal. Errors: those of
  /// Store::create and subdivide.
  Store& made();

 private:
  std::uint64_t level_bytes() const;

  const StoreStructure& structure_;
  const RepairOptions& options_;
  const BackendRegistry& backends_;
  PartialDirectory& scratch_;
  std::string refusal_;
  SubdivideOptions subdivide_;
  bool double_precision_ = false;
  std::optional<Store> made_;
};

}  // namespace plait
