// bench/paper/runs.h: subdivides a mesh by one executor on one backend, in a process of its own,
// and measures what section 6 of the paper reports: elapsed time, processor time, memory and disk.
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "plait/extend/backend_registry.h"

namespace plait::paper {

/// The executor's name for the paper's own way (paper/paper_way.h).
constexpr const char* kPaperWay = "paper";

/// What all runs of a mesh have in common.
struct RunSettings {
  std::filesystem::path mesh;     ///< a file that read_base_mesh() reads
  std::filesystem::path scratch;  ///< stores are made here and removed after each run
  int levels = 5;
  int threads = 1;
  std::uint64_t limit_bytes = 0;  ///< a memory limit around each run; 0: none
};

/// What one row of the table measures.
struct PlannedRun {
  std::string executor, backend;
  std::uint64_t budget_bytes = 0;
};

/// Every executor with every backend and budget, except that the paper's own way has one row, on
/// pread and with `circular_buffers` as its budget, and that a backend in memory has one budget.
std::vector<PlannedRun> plan_runs(const std::vector<std::string>& executors,
                                  const std::vector<std::string>& backends,
                                  const std::vector<std::uint64_t>& budgets,
                                  std::uint64_t circular_buffers, const BackendRegistry& registry);

/// Bytes of positions and normals of so many vertices, and of the store's other files.
std::uint64_t store_bytes(std::uint64_t vertices);

/// Carries out one run in a child process: reads the mesh, lays it out, makes positions and
/// normals, commits, and then, outside the measured time, computes the digest. The result has
/// `executor`, `backend`, `budget_bytes`, `layout`, `vertices`, `seconds`, `cpu_seconds`,
/// `peak_rss_bytes`, `stored_bytes`, `bytes_read`, `bytes_written` and `digest`; or `not_run`, the
/// reason, for a backend that cannot be used or a budget that is too small. The paper's own way
/// gets a larger budget than the run's if the pager needs it. Errors: kCancelled after a signal,
/// kNoSpace and kIo. REQUIRES: as instrument::run_in_own_process().
nlohmann::json carry_out(const RunSettings& settings, const PlannedRun& run,
                         const BackendRegistry& registry);

}  // namespace plait::paper
