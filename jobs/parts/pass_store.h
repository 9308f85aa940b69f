// The store that a pass in parts reads and changes.
#pragma once

#include <filesystem>

#include "format/version_description.h"
#include "parts/compute_part.h"
#include "parts/plan_file.h"
#include "store/stored_version.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Throws unless the plan's pass reads this version: then the plan's counts and cuts are those of
/// the store. Returns the description of the next version, as version_after(). `path` is that of
/// the plan. Errors: kBadState for another store and another version; kCorruption for a plan that
/// says other things than the store.
VersionDescription check_pass_fits(const PlanFile& plan, const StoredVersion& version,
                                   const std::filesystem::path& path);

/// Makes the files of the part's levels in `directory`, which is empty, and syncs them. Errors: as
/// make_part().
ComputedPart compute_pass_part(const PlanFile& plan, std::uint32_t part, const Directory& plan_path,
                               const Directory& directory, const PartOptions& options,
                               const BackendRegistry& backends);

PLAIT_END_NAMESPACE
