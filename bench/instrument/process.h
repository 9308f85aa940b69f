// bench/instrument/process.h: runs work in a process of its own, so that memory, faults and
// processor time are those of this work alone.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

namespace plait::instrument {

class MemoryLimit;

/// What the kernel counted for a process, from its start to its end.
struct ProcessFigures {
  double user_seconds = 0, system_seconds = 0;
  std::uint64_t peak_rss_bytes = 0;  ///< VmHWM since the work began; 0 if not known
  std::uint64_t minor_faults = 0, major_faults = 0;
};

/// The result of the work, and the figures of its process.
struct ProcessResult {  // NOLINT(bugprone-exception-escape): moving json ends in an assertion
  nlohmann::json result;
  ProcessFigures figures;
};

/// Forks, runs `work` in the child (inside `limit`, if one is given) and returns its result. The
/// child is killed when this process dies; signals end it at once. An error of the child is thrown
/// here with its code and its message; a child that a signal ended is kOutOfMemory if the signal is
/// SIGKILL and there was a limit, else kIo. REQUIRES: this process has no other thread, and none of
/// TBB, because a child has only the thread that forked.
ProcessResult run_in_own_process(const std::function<nlohmann::json()>& work,
                                 const MemoryLimit* limit = nullptr);

/// The result alone.
nlohmann::json in_own_process(const std::function<nlohmann::json()>& work);

/// The number behind the word `after` in a file of /proc or /sys, or the number that the file
/// begins with; nothing if there is none.
std::optional<std::uint64_t> number_in(const std::filesystem::path& file,
                                       const std::string& after = {});

/// Measures by how much the resident set grows from construction to its peak.
class PeakMemory {
 public:
  /// First returns free heap pages to the system, so that pages which the work takes are counted.
  PeakMemory();
  std::uint64_t bytes() const;

 private:
  std::uint64_t before_;
};

/// The output of a shell command; empty if the command fails or is missing.
std::string output_of(const std::string& command);

}  // namespace plait::instrument
