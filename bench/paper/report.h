// bench/paper/report.h: makes the figures of `plait paper`: tables, runs and pictures of one mesh
// after another, each in a process of its own. The result is JSON alone; chapter.h has the words.
#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "paper/models.h"
#include "paper/runs.h"
#include "plait/extend/backend_registry.h"

namespace plait::paper {

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

/// Told before each step: how many are done, of how many, and the next one's name.
using StepProgress =
    std::function<void(std::size_t done, std::size_t total, const std::string& next)>;

/// {"plait", "date", "machine", "environment", "command", "interrupted", "failed", "models":
/// [{"name", "title", "source", "is_stand_in", "levels", "paper", "tables", "runs",
/// "digests_equal", "digest", "pictures"}]}. After a signal it returns what there is, with
/// `interrupted` true. `failed` is true if runs of one mesh have different digests. The stores and
/// the mesh are made in `scratch`. Errors: kInvalidArgument for a name that does not exist, a mesh
/// with several models, or files that exist; kNoSpace if the disk would be more than nine tenths
/// full; kIo. REQUIRES: as instrument::run_in_own_process().
nlohmann::ordered_json make_report(const ReportRequest& request, const BackendRegistry& registry,
                                   const StepProgress& progress,
                                   const std::filesystem::path& scratch);

}  // namespace plait::paper
