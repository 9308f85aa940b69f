// tools/subdivision_report.h: prints the figures of one subdivision, as JSON and as text.
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "plait/subdivision_job.h"

namespace plait {

struct SubdivisionReport {
  std::filesystem::path mesh;
  SubdivisionResult result;
  // Times of the process. `seconds` is the time since its start.
  double seconds = 0, cpu_seconds = 0;
  std::uint64_t peak_rss_bytes = 0;
};

nlohmann::ordered_json to_json(const SubdivisionReport& report);
std::string to_text(const SubdivisionReport& report);

}  // namespace plait
