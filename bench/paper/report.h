// bench/paper/report.h: makes the figures of `plait paper`: tables, runs and pictures of one mesh
// after another, each in a process of its own, and the chapter that shows them.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>

#include "instrument/page.h"
#include "paper/runs.h"

namespace plait::paper {

/// Told before each step: how many are done, of how many, and the next one's name.
using StepProgress =
    std::function<void(std::size_t done, std::size_t total, const std::string& next)>;

/// {"plait", "date", "machine", "environment", "command", "interrupted", "failed", "models":
/// [{"name", "source", "is_stand_in", "levels", "tables", "runs", "digests_equal", "digest",
/// "pictures"}]}. After a signal it returns what there is, with `interrupted` true. `failed` is
/// true if runs of one mesh have different digests. The stores and the mesh are made in `scratch`.
/// Errors: kInvalidArgument for a name that does not exist, a mesh with several models, or files
/// that exist; kNoSpace if the disk would be more than nine tenths full; kIo. REQUIRES: as
/// instrument::run_in_own_process().
nlohmann::ordered_json make_report(const ReportRequest& request, const BackendRegistry& registry,
                                   const StepProgress& progress,
                                   const std::filesystem::path& scratch);

/// The chapter about the paper, in words and tables, from what make_report() returned.
instrument::Page make_chapter(const nlohmann::ordered_json& report);

}  // namespace plait::paper
