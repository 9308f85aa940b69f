// How fast this machine makes the parts of a plan, measured by a trial.
#pragma once

#include <filesystem>

#include "parts/cuts.h"
#include "parts/plan_file.h"
#include "plait/extend/backend_registry.h"
#include "plait/extend/directory.h"
#include "plait/extend/parts.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// What a small part has and takes.
struct Trial {
  double points = 0, bytes = 0;
  double begin_seconds = 0, compute_seconds = 0, write_seconds = 0;

  double seconds() const { return compute_seconds + write_seconds; }
  Trial operator-(const Trial& other) const {
    return {points - other.points, bytes - other.bytes, begin_seconds - other.begin_seconds,
            compute_seconds - other.compute_seconds, write_seconds - other.write_seconds};
  }
};

/// The rates are of what `most` has and takes over `least`; the rest is the same for every part. At
/// least a tenth of the seconds counts, because `least` may have been slowed by another program.
MachineRates rates_of(const Trial& least, const Trial& most);

/// Makes small parts of the plan beside `final_path` and removes them. Takes about two seconds, and
/// what a few parts take whatever their size.
/// `plan` has everything but its parts, and base.mesh is in `plan_directory`. Errors: as
/// make_part().
MachineRates measure_machine(const Directory& plan_directory, const PlanFile& plan,
                             const EdgesInOrder& mesh, const PartCost& cost,
                             const std::filesystem::path& final_path,
                             const ProgressCallback& progress, const BackendRegistry& backends);

/// The seconds of a part whose other figures are there.
double seconds_of(const PlannedPart& part, const PartCost& cost, const MachineRates& rates);

PLAIT_END_NAMESPACE
