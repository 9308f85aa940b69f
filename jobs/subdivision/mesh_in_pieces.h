// Whether a job takes its base mesh in pieces, and what it asks of such a mesh.
#pragma once

#include <optional>

#include "parts/base_in_ranges.h"
#include "plait/extend/backend_registry.h"
#include "plait/subdivision_job.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// The mesh of the request if it is one in files whose arrays are larger than the budget: then the
/// job has half of the budget for a piece of it at a time, and plan.piece_bytes and
/// plan.store.budget_bytes say so. Else nothing: the job reads all of it. Adds a refusal if the
/// request needs the whole mesh. Errors: kNoSpace for the files of sorts; those of
/// open_base_pages().
std::optional<BaseInRanges> mesh_in_pieces(const SubdivisionRequest& request,
                                           SubdivisionPlan& plan);
/// Adds a refusal if the plan, which is complete, needs the whole mesh.
void refuse_pieces(const SubdivisionRequest& request, const BackendTraits& backend,
                   SubdivisionPlan& plan);

PLAIT_END_NAMESPACE
