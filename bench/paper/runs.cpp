#include "paper/runs.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "console.h"
#include "instrument/memory_limit.h"
#include "instrument/process.h"
#include "interrupt.h"
#include "measure.h"
#include "paper/paper_way.h"
#include "plait/digest.h"
#include "plait/error.h"
#include "plait/mesh_io.h"
#include "plait/registry.h"
#include "plait/subdivide.h"

namespace plait::paper {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

constexpr std::uint64_t kVertexBytes = 24;  // position and normal, float32

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

void make_levels(Store& store, const RunSettings& settings, const PlannedRun& run) {
  add_base_positions(store);
  if (run.executor == kPaperWay) return make_in_paper_way(store, settings.levels);
  SubdivideOptions how;
  how.executor = executor_from_name(run.executor);
  how.levels = settings.levels;
  how.normals = true;
  how.threads = how.executor == ExecutorKind::kTransparent ? 1 : settings.threads;
  subdivide(store, how);
}

fs::path store_path(const RunSettings& settings) { return settings.scratch / "store.plait"; }

/// A message without the temporary directory that no reader knows.
std::string without_scratch(std::string message, const fs::path& scratch) {
  const std::string prefix = scratch.native() + "/";
  for (std::size_t at = message.find(prefix); at != std::string::npos; at = message.find(prefix))
    message.erase(at, prefix.size());
  return message;
}

/// In the process of the run.
json measure(const RunSettings& settings, const PlannedRun& run, const BackendRegistry& registry) {
  const bool durable = registry.find(run.backend).traits.durable;
  const Stopwatch clock;
  LaidOutMesh base = lay_out(read_base_mesh(settings.mesh), layout_of(run));
  const StoreOptions options = options_of(run, base, settings.levels);
  const std::uint64_t vertices = counts_at_level(base.mesh, settings.levels).vertices;
  Store store = Store::create(durable ? store_path(settings) : fs::path(), std::move(base), options,
                              registry);
  make_levels(store, settings, run);
  store.commit();
  const double seconds = clock.seconds(), processor = cpu_seconds();
  const std::uint64_t peak = instrument::memory_status("VmHWM");
  const PagingStatistics paging = store.statistics();
  json result = {{"layout", store.provenance().layout},
                 {"budget_bytes", options.budget_bytes},
                 {"vertices", vertices},
                 {"seconds", seconds},
                 {"cpu_seconds", processor},
                 {"peak_rss_bytes", peak},
                 {"stored_bytes", store.stored_bytes()},
                 {"bytes_read", paging.bytes_read},
                 {"bytes_written", paging.bytes_written},
                 {"on_disk", durable}};
  result["digest"] = digest(store, {.threads = settings.threads}).to_string();
  store.close();
  return result;
}

bool is_row(ErrorCode code) {
  return code == ErrorCode::kNotSupported || code == ErrorCode::kBudget ||
         code == ErrorCode::kOutOfMemory;
}

}  // namespace

std::vector<PlannedRun> plan_runs(const std::vector<std::string>& executors,
                                  const std::vector<std::string>& backends,
                                  const std::vector<std::uint64_t>& budgets,
                                  std::uint64_t circular_buffers, const BackendRegistry& registry) {
  std::vector<PlannedRun> runs;
  for (const std::string& executor : executors) {
    if (executor == kPaperWay) {
      runs.push_back({executor, "pread", circular_buffers});
      continue;
    }
    (void)executor_from_name(executor);
    for (const std::string& backend : backends)
      for (const std::uint64_t budget : budgets) {
        const RegisteredBackend& entry = registry.find(backend);
        if (!entry.traits.in_memory || budget == budgets.front())
          runs.push_back({executor, backend, budget});
      }
  }
  return runs;
}

std::uint64_t store_bytes(std::uint64_t vertices) {
  return vertices * kVertexBytes + vertices * kVertexBytes / 20 + (std::uint64_t{4} << 20);
}

json carry_out(const RunSettings& settings, const PlannedRun& run,
               const BackendRegistry& registry) {
  throw_if_interrupted();
  json row = {
      {"executor", run.executor}, {"backend", run.backend}, {"budget_bytes", run.budget_bytes}};
  try {
    std::optional<instrument::MemoryLimit> limit;
    if (settings.limit_bytes != 0) limit.emplace(settings.limit_bytes);
    if (limit && !limit->limited())
      throw Error(ErrorCode::kNotSupported, "limit memory: " + limit->why_not());
    row.update(instrument::run_in_own_process([&] { return measure(settings, run, registry); },
                                              limit ? &*limit : nullptr)
                   .result);
  } catch (const Error& error) {
    throw_if_interrupted();
    if (!is_row(error.code())) throw;
    row["not_run"] = without_scratch(error.what(), settings.scratch);
  }
  fs::remove_all(store_path(settings));
  return row;
}

}  // namespace plait::paper
