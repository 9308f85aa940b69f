// The records of base vertices that the parts have, put together.
#pragma once

#include <cstddef>
#include <vector>

#include "base/zeroed_array.h"
#include "parts/done_file.h"
#include "parts/plan_file.h"
#include "plait/base_mesh.h"
#include "plait/extend/directory.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// The records of all base vertices, for each of `record_bytes`: those of the attributes that the
/// parts make. `parts` are all parts of the plan. Errors: kCorruption, kIo.
std::vector<ZeroedArray<std::byte>> merge_base_records(
    const Directory& plan_directory, const PlanFile& plan, const std::vector<DoneFile>& parts,
    const BaseMesh& mesh, const std::vector<std::size_t>& record_bytes);

PLAIT_END_NAMESPACE
