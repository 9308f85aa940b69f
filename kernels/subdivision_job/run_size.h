// Whether the machine has what a run needs, asked before the run begins. Every refusal names what
// is needed and what is there.
#pragma once

#include <cstdint>

#include "plait/kernels/subdivision_job.h"
#include "plait/store.h"

namespace plait {

/// Of `input` refined plan.store.base_level times in memory. A run that goes on from plan.earlier
/// is measured by what is left to do.
SubdivisionSize size_of_run(const BaseMesh& input, const SubdivisionPlan& plan);

/// Memory for the base mesh, for levels kept in memory, and for what of the budget the run can
/// fill: fills size.memory_bytes and refuses with kOutOfMemory.
void check_memory(SubdivisionPlan& plan, const BackendTraits& backend);
/// Free space and the longest file there may be; left-overs of killed runs, which go before the run
/// begins, count as free. What a backend compresses is counted at a quarter, a guess that lets
/// through what has a chance. Refuses with kNoSpace. Errors: kIo.
void check_disk(SubdivisionPlan& plan, const BackendTraits& backend,
                const std::filesystem::path& store);
/// Frames of the widest pass, for executors that would find out at the finest level only. Refuses
/// with kBudget.
void check_budget(SubdivisionPlan& plan, const Store& store);

}  // namespace plait
