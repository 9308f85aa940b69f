// The store of an earlier run: whether a request can go on from it, and where.
#pragma once

#include <optional>

#include "plait/kernels/subdivision_job.h"
#include "plait/store.h"

namespace plait {

/// The store of an earlier run, opened for writing; none where nothing was committed under the
/// name. What the request left open is taken into the plan from the store. The plan refuses a store
/// that is not the beginning of this subdivision, or was made in another way than the request says:
/// other scheme, precision, backend, codec, filter, block size, layout or base level; limit
/// positions; levels beyond those asked for; normals at a coarser level that were not asked for,
/// and would not fit the surface any more. Errors: as Store::open.
std::optional<Store> open_earlier_run(const SubdivisionRequest& request,
                                      const BackendRegistry& backends, SubdivisionPlan& plan);

/// Refuses the store if its base mesh is not `mesh`, laid out as the store is.
void check_same_mesh(const Store& store, const BaseMesh& mesh, SubdivisionPlan& plan);

}  // namespace plait
