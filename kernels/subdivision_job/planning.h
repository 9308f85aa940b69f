// From what was asked to what is done, as far as it follows from the request alone.
#pragma once

#include <string>
#include <string_view>

#include "plait/kernels/subdivision_job.h"

namespace plait {

void refuse(SubdivisionPlan& plan, std::string_view field, ErrorCode code, std::string reason);
/// The first refusal as an Error, if there is one.
void throw_refusal(const SubdivisionPlan& plan);

/// A plan without an earlier run and without a mesh. Errors: those of backends.find and of the
/// backend's own check of its options.
SubdivisionPlan plan_request(const SubdivisionRequest& request, const BackendRegistry& backends);

/// For a new store: whoever names a codec or a filter must name a backend that takes it; the store
/// of an earlier run has its own.
void check_compression(const SubdivisionRequest& request, const BackendRegistry& backends,
                       SubdivisionPlan& plan);
/// Whether a new store can have its name.
void check_name(const SubdivisionRequest& request, SubdivisionPlan& plan);

}  // namespace plait
