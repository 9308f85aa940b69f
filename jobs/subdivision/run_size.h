// Checks before a run whether the machine has enough memory and disk. Every refusal gives what the
// run needs and what the machine has.
#pragma once

#include <cstdint>

#include "plait/subdivision_job.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Estimates the run for the mesh `input`, which the job refines plan.base_level times in
/// memory. The disk_bytes of a resumed run are those of the remaining work.
SubdivisionSize size_of_run(const BaseMesh& input, const SubdivisionRequest& request,
                            const SubdivisionPlan& plan);

/// Sets size.memory_bytes: the base mesh, levels that the backend has in memory, and the part of
/// the budget that the run can use. Refuses with kOutOfMemory.
void check_memory(SubdivisionPlan& plan, const BackendTraits& backend);
/// Checks the free space and the longest file that is allowed. Left-overs of killed runs count as
/// free, because run() removes them first. For a backend that compresses it takes a quarter of the
/// bytes, which is a guess: data that compresses less may fill the disk later. Refuses with
/// kNoSpace. Errors: kIo.
void check_disk(SubdivisionPlan& plan, const BackendTraits& backend,
                const std::filesystem::path& store);

PLAIT_END_NAMESPACE
