// The part of a plan that follows from the request alone.
#pragma once

#include <string>
#include <string_view>

#include "plait/subdivision_job.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

void refuse(SubdivisionPlan& plan, std::string_view option, ErrorCode code, std::string reason);
/// Throws the first refusal as a JobError, if the plan has one.
void throw_refusal(const SubdivisionPlan& plan);

/// Returns a plan without an earlier run and without a mesh. Errors: those of backends.find and of
/// the backend's own check of its options.
SubdivisionPlan plan_request(const SubdivisionRequest& request, const BackendRegistry& backends);

/// Refuses a codec or a filter for a new store if the request names no backend that compresses.
void check_compression(const SubdivisionRequest& request, const BackendRegistry& backends,
                       SubdivisionPlan& plan);
/// Refuses bounds of errors that the run cannot keep.
void check_bounds(const SubdivisionRequest& request, const BaseMesh& mesh, SubdivisionPlan& plan);
/// Refuses the name of a new store if UnpublishedStore would refuse it.
void check_name(const SubdivisionRequest& request, SubdivisionPlan& plan);

PLAIT_END_NAMESPACE
