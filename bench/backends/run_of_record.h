// bench/backends/run_of_record.h: one record as a run.
#pragma once

#include <nlohmann/json.hpp>

#include "backends/measured_run.h"

namespace plait::bench {

/// Throws BadRecord for what is no record. The caller fills in `file` and `line`.
MeasuredRun run_of_record(const nlohmann::json& record);

}  // namespace plait::bench
