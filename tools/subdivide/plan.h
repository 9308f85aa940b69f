// tools/subdivide/plan.h: from what was asked to what is done. Everything that can be refused
// before the mesh is read is refused here.
#pragma once

#include <cstdint>
#include <string>

#include "plait/backend.h"
#include "plait/kernels/subdivide.h"
#include "plait/layout.h"
#include "plait/options.h"
#include "subdivide/request.h"

namespace plait {

/// The name of a backend that is chosen when the size of the store is known.
inline constexpr const char* kAutomaticBackend = "auto";

struct SubdivisionPlan {
  StoreOptions store;  ///< without `base_level`, and with `backend` "auto" until it is chosen
  std::string backend_reason;
  SubdivideOptions subdivide;
  LayoutKind layout = LayoutKind::kAutomatic;
  bool double_precision = false;
  std::uint64_t max_slot_bytes = 0;
  bool keeps_store = false;     ///< something is left on the disk
  bool commits_levels = false;  ///< under the final name, which --resume asks for
};

/// A plan without an earlier run. Errors: kInvalidArgument, kNotSupported, before anything is
/// touched.
SubdivisionPlan make_plan(const SubdivisionRequest& request, const BackendRegistry& backends);

/// For a new store: whoever names a codec or a filter must name a backend that takes them; an
/// earlier run has its own. Errors: kInvalidArgument naming the option to add.
void require_compression(const SubdivisionRequest& request, const BackendRegistry& backends);

}  // namespace plait
