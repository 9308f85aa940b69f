#include "paper/runs.h"

#include <algorithm>
#include <boost/algorithm/string/erase.hpp>
#include <optional>
#include <utility>

#include "instrument/memory_limit.h"
#include "instrument/process.h"
#include "interrupt.h"
#include "measure.h"
#include "paper/paper_way.h"
#include "plait/digest.h"
#include "plait/error.h"
#include "plait/mesh_io.h"
#include "plait/registry.h"
#include "plait/store_info.h"
#include "plait/subdivide.h"

namespace plait::paper {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

constexpr std::uint64_t kMebibyte = 1 << 20;
constexpr std::uint64_t kFewestBudgetBytes = 64 * kMebibyte;

LayoutKind layout_of(const PlannedRun& run) {
  if (run.executor == kPaperWay) return LayoutKind::kSpatial;
  return executor_from_name(run.executor) == ExecutorKind::kFused ? LayoutKind::kHilbert
                                                                  : LayoutKind::kAutomatic;
}

StoreOptions options_of(const PlannedRun& run, const LaidOutMesh& base, int levels) {
  StoreOptions options;
  options.backend = run.backend;
  options.budget_bytes = run.budget_bytes;
  if (run.executor != kPaperWay) return options;
  // The paper reads and writes when a buffer moves on, in the thread that computes.
  options.io_threads = 0;
  Store scratch = Store::create({}, base.mesh, {.backend = "memory"}, default_backends());
  add_base_positions(scratch);
  options.budget_bytes = std::max(options.budget_bytes, paper_way_bytes(scratch, levels));
  return options;
}

void make_levels(Store& store, const ReportRequest& request, const PlannedRun& run) {
  add_base_positions(store);
  if (run.executor == kPaperWay) return make_in_paper_way(store, request.levels);
  subdivide(store, {.executor = executor_from_name(run.executor),
                    .levels = request.levels,
                    .normals = true,
                    .threads = request.threads});
}

/// In the process of the run.
json measure(const ReportRequest& request, const fs::path& path, const PlannedRun& run,
             const BackendRegistry& registry) {
  const bool durable = registry.find(run.backend).traits.durable;
  const Stopwatch clock;
  LaidOutMesh base = lay_out(read_base_mesh(request.mesh), layout_of(run));
  const StoreOptions options = options_of(run, base, request.levels);
  Store store = Store::create(durable ? path : fs::path(), std::move(base), options, registry);
  make_levels(store, request, run);
  store.commit();
  json result = {{"seconds", clock.seconds()},
                 {"cpu_seconds", cpu_seconds()},
                 {"peak_rss_bytes", peak_rss_bytes()},
                 {"layout", store.provenance().layout},
                 {"budget_bytes", options.budget_bytes},
                 {"vertices", counts_at_level(store.base(), request.levels).vertices},
                 {"stored_bytes", store.info().stored_bytes},
                 {"on_disk", durable}};
  result["digest"] = digest(store, {.threads = request.threads}).to_string();
  store.close();
  return result;
}

bool is_row(ErrorCode code) {
  return code == ErrorCode::kNotSupported || code == ErrorCode::kBudget ||
         code == ErrorCode::kOutOfMemory;
}

}  // namespace

std::vector<PlannedRun> plan_runs(const ReportRequest& request, const Model& model,
                                  std::uint64_t loop_span, const BackendRegistry& registry) {
  const std::uint64_t buffers = circular_buffer_bytes(loop_span, request.levels);
  std::vector<std::uint64_t> budgets = request.budgets;
  if (budgets.empty()) {
    budgets = {std::max(kFewestBudgetBytes, (buffers + kMebibyte - 1) / kMebibyte * kMebibyte)};
    if (model.elapsed.size() == 2) budgets.push_back(4 * budgets[0]);
  }
  std::vector<PlannedRun> runs;
  for (const std::string& executor : request.executors) {
    if (executor == kPaperWay) {
      runs.push_back({executor, "pread", buffers});
      continue;
    }
    for (const std::string& backend :
         request.backends.empty() ? registry.names() : request.backends)
      for (const std::uint64_t budget : budgets)
        if (!registry.find(backend).traits.in_memory || budget == budgets.front())
          runs.push_back({executor, backend, budget});
  }
  return runs;
}

json carry_out(const ReportRequest& request, const fs::path& scratch, const PlannedRun& run,
               const BackendRegistry& registry) {
  throw_if_interrupted();
  json row = {
      {"executor", run.executor}, {"backend", run.backend}, {"budget_bytes", run.budget_bytes}};
  const fs::path path = scratch / "store.plait";
  try {
    std::optional<instrument::MemoryLimit> limit;
    if (request.limit_bytes != 0) limit.emplace(request.limit_bytes);
    if (limit && !limit->limited())
      throw Error(ErrorCode::kNotSupported, "limit memory: " + limit->why_not());
    row.update(instrument::run_in_own_process([&] { return measure(request, path, run, registry); },
                                              limit ? &*limit : nullptr)
                   .result);
  } catch (const Error& error) {
    throw_if_interrupted();
    if (!is_row(error.code())) throw;
    // No reader knows the temporary directory.
    row["not_run"] =
        boost::algorithm::erase_all_copy(std::string(error.what()), scratch.native() + "/");
  }
  fs::remove_all(path);
  return row;
}

}  // namespace plait::paper
