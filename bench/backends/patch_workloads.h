// bench/backends/patch_workloads.h: workloads that read through a Reader.
// bench/backends/workloads.h lists them.
#pragma once

#include <nlohmann/json.hpp>

#include "backends/workloads.h"

namespace plait::bench {

/// Without a rate each thread reads the next patch when it has the last one (a closed loop). With
/// one, requests are due at fixed instants, and a latency counts from there: a stall is in the
/// latency of all requests that waited behind it.
nlohmann::ordered_json patch_random(const WorkloadRun& run);
nlohmann::ordered_json scan_export(const WorkloadRun& run);

}  // namespace plait::bench
