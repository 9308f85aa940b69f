// The computation of a part, in a directory that nobody else writes to.
#pragma once

#include <cstdint>

#include "parts/plan_file.h"
#include "plait/digest.h"
#include "plait/extend/backend_registry.h"
#include "plait/extend/directory.h"
#include "plait/extend/parts.h"
#include "store/parts/part_store.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

struct ComputedPart {
  PartContent content;
  Digest digest;
  double begin_seconds = 0;    ///< to read the base mesh and to create the levels
  double compute_seconds = 0;  ///< to refine, and to compute the digest
  double write_seconds = 0;    ///< to write what was in memory, and to sync
};

/// Makes the files of the levels in `directory`, which is empty, and syncs them. Errors: as
/// make_part().
ComputedPart compute_part(const Directory& plan_directory, const PlanFile& plan, std::uint32_t part,
                          const Directory& directory, const PartOptions& options,
                          const BackendRegistry& backends);

PLAIT_END_NAMESPACE
