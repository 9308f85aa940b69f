// bench/paper/runs.h: what a user asks of `plait paper`, and the runs that it takes: each
// subdivides a mesh by one executor on one backend, in a process of its own, and measures what
// section 6 of the paper reports: elapsed time, processor time, memory and disk.
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "paper/models.h"
#include "plait/extend/backend_registry.h"

namespace plait::paper {

/// The executor's name for the paper's own way (paper/paper_way.h).
constexpr const char* kPaperWay = "paper";

/// What the user asks for.
struct ReportRequest {
  std::vector<std::string> models = {"deo"};
  std::filesystem::path mesh;  ///< instead of a stand-in; for one model
  std::uint64_t vertices = 0;  ///< of a small stand-in; 0: the paper's counts
  int levels = 0;              ///< 0: the paper's
  std::vector<std::string> executors = {kPaperWay, "fused", "sweep", "transparent"};
  std::vector<std::string> backends;   ///< empty: all that this machine can use
  std::vector<std::uint64_t> budgets;  ///< empty: the paper's circular buffers, at least 64 MiB
  std::uint64_t limit_bytes = 0;       ///< a memory limit around each run; 0: none
  int threads = 1;
  bool runs = true;
  std::filesystem::path directory = ".";     ///< on the disk where stores and the mesh are made
  std::filesystem::path pictures_directory;  ///< empty: no pictures
};

/// What one row of the table measures.
struct PlannedRun {
  std::string executor, backend;
  std::uint64_t budget_bytes = 0;
};

/// Every executor with every backend and budget, except that the paper's own way has one row, on
/// pread and with its circular buffers as budget, and that a backend in memory has one budget.
/// REQUIRES: request.levels is not 0.
std::vector<PlannedRun> plan_runs(const ReportRequest& request, const Model& model,
                                  std::uint64_t loop_span, const BackendRegistry& registry);

/// Carries out one run in a child process: reads `request.mesh`, lays it out, makes positions and
/// normals to `request.levels` in a store in `scratch`, commits, and then, outside the measured
/// time, computes the digest. The result has `executor`, `backend`, `budget_bytes`, `layout`,
/// `vertices`, `seconds`, `cpu_seconds`, `peak_rss_bytes`, `stored_bytes`, `on_disk` and `digest`;
/// or `not_run`, the reason, for a backend that cannot be used or a budget that is too small. The
/// paper's own way gets a larger budget than the run's if the pager needs it. Errors: kCancelled
/// after a signal, kNoSpace and kIo. REQUIRES: as instrument::run_in_own_process().
nlohmann::json carry_out(const ReportRequest& request, const std::filesystem::path& scratch,
                         const PlannedRun& run, const BackendRegistry& registry);

}  // namespace plait::paper
