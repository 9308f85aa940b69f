#include "backends/workloads.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>

#include "backends/measured_store.h"
#include "backends/patch_workloads.h"
#include "base/stopwatch.h"
#include "plait/digest.h"
#include "plait/error.h"
#include "plait/extend/store_access.h"
#include "plait/extend/sweep.h"
#include "plait/subdivide.h"

namespace plait::bench {
namespace {

nlohmann::ordered_json build(const WorkloadRun& run) {
  const LaidOutMesh base = base_mesh(run.cell);
  const Stopwatch clock;
  Store store = Store::create(run.store, base, options_of_new_store(run), *run.backends);
  add_base_positions(store);
  subdivide(
      store,
      {.executor = ExecutorKind::kFused, .levels = run.cell.levels, .threads = run.cell.threads});
  encode_anew(run, store);
  const double made = clock.seconds();
  store.commit();
  const double seconds = clock.seconds();
  nlohmann::ordered_json result = counted(store, run, seconds, seconds - made);
  result["needed_read"] = 0;
  result["needed_written"] = run.cell.raw_bytes();
  store.close();
  // What was written is read back, outside the time.
  Store written = open_for_reading(run);
  result["digest"] = {{"of", "built surface of " + surface_name(run.cell)},
                      {"value", digest(written, {.threads = run.cell.threads}).to_string()}};
  return result;
}

nlohmann::ordered_json sweep_read(const WorkloadRun& run) {
  const Stopwatch clock;
  Store store = open_for_reading(run);
  const std::string digest = sweep_digest(store, run.cell);
  nlohmann::ordered_json result = counted(store, run, clock.seconds());
  std::uint64_t needed = 0;
  for (int level = 1; level <= run.cell.levels; ++level)
    needed +=
        StoreAccess::level_file(store, store.attribute(kAttribute), level).geometry.total_bytes();
  result["needed_read"] = needed;
  result["needed_written"] = 0;
  result["digest"] = {{"of", "surface of " + surface_name(run.cell)}, {"value", digest}};
  return result;
}

/// Turns the lowest bit of each number of all levels, and commits.
nlohmann::ordered_json sweep_update(const WorkloadRun& run) {
  OpenOptions options;
  options.writable = true;
  options.budget_bytes = run.cell.budget_bytes;
  nlohmann::ordered_json result;
  {
    const Stopwatch clock;
    Store store = Store::open(run.store, options, *run.backends);
    SweepPass pass;
    pass.name = "update";
    pass.accesses = {
        {store.attribute(kAttribute), 1, run.cell.levels, Access::kUpdate, Reach::kOwn}};
    pass.kernel = [&](const SweepView& view, EdgeId edge, int) {
      for (int level = 1; level <= run.cell.levels; ++level)
        for (std::uint32_t& word : view.records<std::uint32_t>(0, level, edge)) word ^= 1;
    };
    sweep(store, pass, {.threads = run.cell.threads});
    const double swept = clock.seconds();
    store.commit();
    const double seconds = clock.seconds();
    result = counted(store, run, seconds, seconds - swept);
  }
  result["needed_read"] = result["needed_written"] = run.cell.raw_bytes();
  Store written = open_for_reading(run);
  result["digest"] = {{"of", "surface of " + surface_name(run.cell)},
                      {"value", sweep_digest(written, run.cell)}};
  return result;
}

using instrument::FloorKind;
constexpr std::array kWorkloads = {
    Workload{"build", "make all levels from the base mesh (fused), durable", FloorKind::kWrite,
             true, false, false, build},
    Workload{"sweep-read", "read all levels in order", FloorKind::kRead, false, true, false,
             sweep_read},
    Workload{"sweep-update", "read and overwrite all levels, durable", FloorKind::kUpdate, false,
             true, true, sweep_update},
    Workload{"scan-export", "read all vertices level by level, as an export does", FloorKind::kRead,
             false, true, false, scan_export},
    Workload{"patch-random", "read patches, all equally likely; with --rate an open loop",
             FloorKind::kRandomRead, false, false, false, patch_random},
};

}  // namespace

std::span<const Workload> workloads() { return kWorkloads; }

const Workload& workload_from_name(std::string_view name) {
  std::vector<std::string_view> names;
  for (const Workload& workload : kWorkloads) {
    if (workload.name == name) return workload;
    names.push_back(workload.name);
  }
  throw Error(ErrorCode::kInvalidArgument,
              fmt::format("find a workload: expected one of {}, found \"{}\"",
                          fmt::join(names, ", "), name));
}

void prepare_store(const WorkloadRun& run) {
  const StoreOptions options = options_of_new_store(run);
  Store store = Store::create(run.store, base_mesh(run.cell), options, *run.backends);
  add_base_positions(store);
  subdivide(
      store,
      {.executor = ExecutorKind::kFused, .levels = run.cell.levels, .threads = run.cell.threads});
  SweepPass pass;
  pass.name = "noise";
  pass.accesses = {{store.attribute(kAttribute), 1, run.cell.levels, Access::kUpdate, Reach::kOwn}};
  pass.kernel = [&](const SweepView& view, EdgeId edge, int) {
    for (int level = 1; level <= run.cell.levels; ++level) {
      std::uint64_t state = std::uint64_t{edge} * 64 + static_cast<std::uint64_t>(level);
      for (std::uint32_t& word : view.records<std::uint32_t>(0, level, edge)) {
        state = state * 6364136223846793005u + 1442695040888963407u;
        word = (word & ~0x3fu) | (static_cast<std::uint32_t>(state >> 40) & 0x3eu);
      }
    }
  };
  sweep(store, pass, {.threads = run.cell.threads});
  encode_anew(run, store);
  store.commit();
  store.close();
}

}  // namespace plait::bench
