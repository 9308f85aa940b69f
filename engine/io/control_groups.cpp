#include "io/control_groups.h"

#include <fmt/format.h>
#include <sched.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <optional>
#include <sstream>
#include <thread>

#include "plait/error.h"
#include "plait/progress.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr int kMostProcessors = 1024;  // and threads

/// The processors that the calling thread may run on.
int processors_of_affinity() {
  cpu_set_t* const set = CPU_ALLOC(kMostProcessors);
  if (set == nullptr) return 1;
  const std::size_t bytes = CPU_ALLOC_SIZE(kMostProcessors);
  CPU_ZERO_S(bytes, set);
  const int found = ::sched_getaffinity(0, bytes, set) == 0
                        ? CPU_COUNT_S(bytes, set)
                        : static_cast<int>(std::thread::hardware_concurrency());
  CPU_FREE(set);
  return found;
}

/// Processor seconds a second; nothing if the group has no limit of its own.
std::optional<double> quota_of(const ControlGroup& group) {
  std::string quota;
  double period = 0;
  if (group.is_version_2) {
    std::ifstream(group.directory / "cpu.max") >> quota >> period;
  } else {
    std::ifstream(group.directory / "cpu.cfs_quota_us") >> quota;
    std::ifstream(group.directory / "cpu.cfs_period_us") >> period;
  }
  double microseconds = 0;
  std::from_chars(quota.data(), quota.data() + quota.size(), microseconds);  // "max" stays 0
  if (microseconds <= 0 || period <= 0) return std::nullopt;
  return microseconds / period;
}

}  // namespace

std::vector<ControlGroup> control_groups(std::string_view controller,
                                         const ControlGroupFiles& files) {
  std::vector<ControlGroup> found;
  std::ifstream lines(files.groups);
  for (std::string line; std::getline(lines, line);) {
    // "HIERARCHY:CONTROLLERS:PATH"; version 2 is hierarchy 0 without controllers.
    std::istringstream parts(line);
    std::string hierarchy, controllers, path;
    std::getline(parts, hierarchy, ':');
    std::getline(parts, controllers, ':');
    std::getline(parts, path);
    const bool is_version_2 = hierarchy == "0" && controllers.empty();
    if (!is_version_2 &&
        ("," + controllers + ",").find("," + std::string(controller) + ",") == std::string::npos)
      continue;
    const std::filesystem::path root = is_version_2 ? files.mounted : files.mounted / controller;
    for (std::filesystem::path at = path;; at = at.parent_path()) {
      found.push_back({root / at.relative_path(), is_version_2});
      if (!at.has_relative_path()) break;
    }
  }
  return found;
}

int usable_processors(const ControlGroupFiles& files) {
  int usable = processors_of_affinity();
  for (const ControlGroup& group : control_groups("cpu", files))
    if (const std::optional<double> quota = quota_of(group))
      usable = static_cast<int>(std::min<double>(usable, std::ceil(*quota)));
  if (const char* const text = std::getenv("SLURM_CPUS_PER_TASK")) {
    const std::string_view given = text;
    int processors = 0;
    std::from_chars(given.data(), given.data() + given.size(), processors);
    if (processors > 0) usable = std::min(usable, processors);
  }
  return std::clamp(usable, 1, kMostProcessors);
}

int thread_count(int threads, std::string_view work) {
  if (threads < 0 || threads > kMostProcessors)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("{}: {} threads, expected 1 to {}, or 0 for all processors", work,
                            threads, kMostProcessors));
  if (threads > 0) return threads;
  return usable_processors();
}

PLAIT_END_NAMESPACE
