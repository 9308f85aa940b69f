// bench/instrument/environment.h: on what, when and by which sources something was measured: the
// same in every record and report.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "instrument/disk.h"

namespace plait::instrument {

/// {plait, commit, kernel, processor, processors, memory, disk}. `commit` is null if it is not
/// known.
nlohmann::ordered_json environment(const DiskFacts& disk);

/// "2 x Xeon, Linux 6.1, ext4 on vda", of what environment() returned.
std::string machine_text(const nlohmann::ordered_json& environment);

/// Today, "2026-11-23".
std::string date_text();

}  // namespace plait::instrument
