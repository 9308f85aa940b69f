// The store of an earlier run, and whether a job can continue from it.
#pragma once

#include <optional>

#include "plait/store.h"
#include "plait/subdivision_job.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Opens the store of an earlier run for writing, and copies to the plan what the request does not
/// give. Returns nothing if the name has no committed store. Refuses a store that differs from the
/// request in scheme, precision, backend, codec, filter, block size, layout or base level; one with
/// limit positions; one with finer levels than the request; and one with normals at a coarser level
/// if the request does not ask for normals, because they would not fit the finer surface.
/// Errors: as Store::open.
std::optional<Store> open_earlier_run(const SubdivisionRequest& request,
                                      const BackendRegistry& backends, SubdivisionPlan& plan);

/// Refuses the store if its base mesh is not `mesh`, which has the layout of the store.
void check_same_mesh(const Store& store, const BaseMesh& mesh, SubdivisionPlan& plan);

PLAIT_END_NAMESPACE
