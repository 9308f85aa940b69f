// tools/subdivide/resume.h: a subdivision that commits every level and can go on where it was
// interrupted, or from where it had been finished.
#pragma once

#include <optional>

#include "plait/kernels/subdivide.h"
#include "plait/layout.h"
#include "plait/store.h"
#include "subdivide/plan.h"
#include "subdivide/request.h"

namespace plait {

/// The store of an earlier run, opened for going on; none where nothing was committed under the
/// name. What the request left open is taken into the plan from the store. Errors: as Store::open;
/// kInvalidArgument if the store is not the beginning of this subdivision, or was made in another
/// way than the request says: other scheme, precision, backend, codec, filter, block size, layout
/// or refinement in memory; limit positions; levels beyond those asked for; normals at a coarser
/// level that were not asked for, and would not fit the surface any more.
std::optional<Store> open_earlier_run(const SubdivisionRequest& request,
                                      const BackendRegistry& backends, SubdivisionPlan& plan);

/// Errors: kInvalidArgument if the store's base mesh is not `mesh`, laid out as the store is.
void require_same_mesh(const Store& store, const BaseMesh& mesh);

/// Whether nothing of the subdivision is left to do.
bool is_finished(const Store& store, const SubdivideOptions& subdivision);

}  // namespace plait
