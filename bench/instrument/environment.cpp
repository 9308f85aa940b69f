#include "instrument/environment.h"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <sys/utsname.h>

#include <chrono>
#include <fstream>
#include <string>
#include <string_view>
#include <thread>

#include "instrument/process.h"
#include "plait/version.h"

namespace plait::instrument {

/// The git commit of the sources that this program was built from, with "-dirty" behind it if they
/// had changes that no commit has. Empty if they were no git checkout. Each build defines it anew
/// (find_commit.cmake).
std::string_view built_from_commit();

namespace {

/// Empty if the kernel does not tell it, as on most machines that are not x86.
std::string processor_name() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);)
    if (line.starts_with("model name"))
      if (const std::size_t colon = line.find(": "); colon != std::string::npos)
        return line.substr(colon + 2);
  return {};
}

}  // namespace

nlohmann::ordered_json environment(const DiskFacts& disk) {
  utsname names{};
  ::uname(&names);
  const std::string commit(built_from_commit());
  return {
      {"plait", PLAIT_VERSION},
      {"commit", commit.empty() ? nlohmann::ordered_json(nullptr) : nlohmann::ordered_json(commit)},
      {"kernel", fmt::format("{} {}", names.sysname, names.release)},
      {"processor", processor_name()},
      {"processors", std::thread::hardware_concurrency()},
      {"memory", number_in("/proc/meminfo", "MemTotal:").value_or(0) * 1024},
      {"disk", to_json(disk)}};
}

std::string machine_text(const nlohmann::ordered_json& environment) {
  const std::string processor = environment["processor"].get<std::string>();
  return fmt::format("{} x {}, {}, {}", environment["processors"].get<unsigned>(),
                     processor.empty() ? "unknown processor" : processor,
                     environment["kernel"].get<std::string>(),
                     environment["disk"]["name"].get<std::string>());
}

std::string date_text() {
  return fmt::format(
      "{:%Y-%m-%d}",
      fmt::gmtime(std::chrono::system_clock::to_time_t(std::chrono::system_clock::now())));
}

}  // namespace plait::instrument
