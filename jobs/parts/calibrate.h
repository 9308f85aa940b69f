// How fast this machine makes the parts of a plan, measured by a trial.
#pragma once

#include <filesystem>

#include "parts/cuts.h"
#include "parts/plan_file.h"
#include "plait/extend/backend_registry.h"
#include "plait/extend/directory.h"
#include "plait/extend/parts.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Makes small parts of the plan beside `final_path` and removes them, for about two seconds.
/// `plan` has everything but its parts, and base.mesh is in `plan_directory`. Errors: as
/// make_part().
MachineRates measure_machine(const Directory& plan_directory, const PlanFile& plan,
                             const Topology& mesh, const PartCost& cost,
                             const std::filesystem::path& final_path,
                             const ProgressCallback& progress, const BackendRegistry& backends);

/// The seconds of a part whose other figures are there.
double seconds_of(const PlannedPart& part, const PartCost& cost, const MachineRates& rates);

PLAIT_END_NAMESPACE
