// How long does it take to write a Loop surface with normals to the disk, for every backend and
// budget, compared with writing as many bytes without computing them?
//
//   plait_bench_loop_to_disk [--mesh FILE] [--levels 5] [--budgets 32,128,1024] [--runs 5]
//                            [--backends pread,mmap ...] [--executor fused] [--threads 2]
//                            [--layout hilbert] [--directory .] [--json FILE]
//
// Without --mesh it takes an octahedron, refined in memory to 32768 faces. Budgets are in MiB. The
// backends are all durable ones, the compressed one with lz4. A run goes from a base mesh in
// memory, in its layout, to a committed store, with fdatasync. Each run has its own process, so
// that the peak of memory is that of the run. The floor writes as many bytes in the backend's own
// way, with as many threads, before and after every run; a run is compared with the mean of the
// two. The first run does not count. The program fails if two runs have different digests.
#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "command_line.h"
#include "instrument/process.h"
#include "plait/backends/registry.h"
#include "plait/digest.h"
#include "plait/error.h"
#include "plait/layout.h"
#include "plait/mesh_io.h"
#include "plait/store.h"
#include "support.h"
#include "write_floors.h"

namespace {

using namespace plait;
using namespace plait::bench;
namespace fs = std::filesystem;

struct Settings {
  std::string mesh, executor = "fused", layout = "hilbert", directory = ".", json;
  std::vector<std::string> backends;
  std::vector<std::uint64_t> budgets = {32, 128, 1024};  // MiB
  int levels = 5, runs = 5, threads = 2;
};

struct Case {
  BackendRegistry::Entry backend;
  std::uint64_t budget_mebibytes;
  std::string not_run = {};  ///< why there are no figures
  std::vector<double> seconds = {}, floors = {}, ratios = {};
  std::uint64_t vertices = 0, stored_bytes = 0, peak_bytes = 0;
  double wait_seconds = 0;
  std::string digest = {};
};

WriteMethod method_of(const BackendRegistry::Entry& backend) {
  if (backend.traits.maps_for_reading) return WriteMethod::kMapped;
  if (backend.name == "uring") return WriteMethod::kDirect;
  return backend.name == "pread" ? WriteMethod::kBegun : WriteMethod::kBuffered;
}

/// Runs in a process of its own.
nlohmann::json make_store(const Settings& settings, const Case& at) {
  LaidOutMesh base = lay_out(settings.mesh.empty() ? octahedron(6) : read_base_mesh(settings.mesh),
                             layout_from_name(settings.layout));
  StoreOptions options;
  options.backend = at.backend.name;
  options.pipeline = at.backend.traits.compressed ? "shuffle,lz4" : "none";
  options.budget_bytes = at.budget_mebibytes << 20;
  options.layout = std::string(to_string(base.kind));
  at.backend.validate({});
  SubdivideOptions how;
  how.levels = settings.levels;
  how.normals = true;
  how.threads = settings.threads;
  how.executor = executor_from_name(settings.executor);
  const std::uint64_t vertices = counts_at_level(base.mesh, settings.levels).vertices;
  const fs::path path = fs::path(settings.directory) / "plait-bench.plait";

  const instrument::PeakMemory peak;
  std::optional<Store> store;
  const double elapsed = seconds([&] {
    store.emplace(Store::create(path, std::move(base.mesh), options, default_backends()));
    add_base_positions(*store);
    subdivide(*store, how);
    store->commit();
  });
  // This memory grows with the base mesh only, so it is not counted, like the base mesh itself.
  std::uint64_t of_base = subdivide_resident_bytes(*store, how);
  for (AttributeId id = 0; id < store->attributes().size(); ++id)
    of_base += store->base_bytes(id).size();
  const std::uint64_t peak_bytes = peak.bytes();
  const PagingStatistics paging = store->statistics();
  return {{"vertices", vertices},
          {"seconds", elapsed},
          {"stored_bytes", store->stored_bytes()},
          {"peak_bytes", peak_bytes > of_base ? peak_bytes - of_base : 0},
          {"wait_seconds", 1e-9 * static_cast<double>(paging.read_wait_ns + paging.write_wait_ns)},
          {"digest", digest(*store).to_string()}};
}

/// One run. The floor before it is known already; this measures the floor after it.
void run_once(const Settings& settings, Case& at, WriteFloor& floor, bool counts) {
  const fs::path path = fs::path(settings.directory) / "plait-bench.plait";
  fs::remove_all(path);
  const nlohmann::json result =
      instrument::in_own_process([&] { return make_store(settings, at); });
  fs::remove_all(path);
  at.vertices = result["vertices"];
  at.stored_bytes = result["stored_bytes"];
  if (!at.digest.empty() && at.digest != result["digest"])
    throw Error(ErrorCode::kCorruption,
                fmt::format("{}: digest {}, expected {} as before", at.backend.name,
                            result["digest"].dump(), at.digest));
  at.digest = result["digest"];
  at.floors.push_back(floor.seconds_for(method_of(at.backend), at.stored_bytes));
  if (!counts) return;
  at.seconds.push_back(result["seconds"]);
  at.ratios.push_back(2 * at.seconds.back() / (at.floors.end()[-2] + at.floors.back()));
  at.peak_bytes = std::max<std::uint64_t>(at.peak_bytes, result["peak_bytes"]);
  at.wait_seconds = std::max<double>(at.wait_seconds, result["wait_seconds"]);
}

void run_case(const Settings& settings, Case& at) {
  try {
    WriteFloor floor(settings.directory, settings.threads);
    for (int turn = 0; turn <= settings.runs; ++turn) {
      say_progress(fmt::format("{}, budget {} MiB: run {} of {}", at.backend.name,
                               at.budget_mebibytes, turn, settings.runs));
      run_once(settings, at, floor, turn > 0);
    }
  } catch (const Error& error) {
    fs::remove_all(fs::path(settings.directory) / "plait-bench.plait");
    if (error.code() != ErrorCode::kNotSupported && error.code() != ErrorCode::kBudget) throw;
    at.not_run = error.what();
  }
}

nlohmann::json report(const Case& at) {
  const std::string name =
      at.backend.traits.compressed ? at.backend.name + " lz4" : at.backend.name;
  if (!at.not_run.empty()) {
    fmt::print("| {} | {} | not run: {} |\n", name, at.budget_mebibytes, at.not_run);
    return {{"backend", name}, {"budget_mebibytes", at.budget_mebibytes}, {"not_run", at.not_run}};
  }
  const double time = median(at.seconds), floor = median(at.floors), ratio = median(at.ratios);
  const Spread times = spread(at.seconds), ratios = spread(at.ratios);
  const double nanoseconds = 1e9 * time / double(at.vertices);
  const double gigabytes = 1e-9 * double(at.stored_bytes) / time;
  fmt::print(
      "| {} | {} | {:.2f} ({:.2f} to {:.2f}) | {} | {:.2f} | {:.2f} ({:.2f} to {:.2f}) | {:.1f} | "
      "{:.2f} | {:.0f} | {:.2f} |\n",
      name, at.budget_mebibytes, time, times.smallest, times.largest,
      to_string(method_of(at.backend)), floor, ratio, ratios.smallest, ratios.largest, nanoseconds,
      gigabytes, double(at.peak_bytes) / (1 << 20), at.wait_seconds);
  return {{"backend", name},
          {"budget_mebibytes", at.budget_mebibytes},
          {"vertices", at.vertices},
          {"seconds", time},
          {"seconds_min", times.smallest},
          {"seconds_max", times.largest},
          {"floor", to_string(method_of(at.backend))},
          {"floor_seconds", floor},
          {"over_floor", ratio},
          {"over_floor_min", ratios.smallest},
          {"over_floor_max", ratios.largest},
          {"ns_per_vertex", nanoseconds},
          {"gigabytes_per_second", gigabytes},
          {"stored_bytes", at.stored_bytes},
          {"peak_bytes", at.peak_bytes},
          {"wait_seconds", at.wait_seconds},
          {"digest", at.digest}};
}

int run(const Settings& settings) {
  std::vector<BackendRegistry::Entry> backends;
  for (const std::string& name :
       settings.backends.empty() ? default_backends().names() : settings.backends) {
    const BackendRegistry::Entry& entry = default_backends().find(name);
    if (entry.traits.durable)
      backends.push_back(entry);
    else if (!settings.backends.empty())
      throw Error(ErrorCode::kInvalidArgument, "backend " + name + " keeps nothing on a disk");
  }
  fmt::print(
      "level {}, executor {}, layout {}, {} threads, {} runs\n\n"
      "| backend | budget, MiB | seconds (min to max) | floor | floor, s | over floor (min to max) "
      "| ns a vertex | GB/s | peak memory less base mesh, MiB | waits, s |\n"
      "|---|---|---|---|---|---|---|---|---|---|\n",
      settings.levels, settings.executor, settings.layout, settings.threads, settings.runs);
  std::fflush(stdout);
  nlohmann::json rows = nlohmann::json::array();
  std::string digest;
  std::uint64_t vertices = 0;
  for (const std::uint64_t budget : settings.budgets)
    for (const BackendRegistry::Entry& backend : backends) {
      Case at{backend, budget};
      at.digest = digest;
      run_case(settings, at);
      rows.push_back(report(at));
      std::fflush(stdout);
      digest = at.digest;
      vertices = std::max(vertices, at.vertices);
    }
  fmt::print("\n{} vertices, digest {} in every run\n", vertices, digest);
  write_json(settings.json, rows);
  return 0;
}

}  // namespace

int main(int count, char** words) {
  Settings settings;
  return run_program(
      "plait_bench_loop_to_disk",
      "Loop surfaces with normals to the disk, compared with writing as many bytes", count, words,
      [&](CommandLine& app) {
        add_mesh_option(app, settings.mesh, "an octahedron refined to 32,768 faces");
        add_number_option(app, "--levels", settings.levels, 1, 12, "The level to refine to");
        app.add_option("--budgets", settings.budgets, "Budgets for blocks in memory, MiB")
            ->delimiter(',')
            ->range(1, 1 << 20);
        app.add_option("--backends", settings.backends, "Durable backends; default: all of them")
            ->delimiter(',');
        add_runs_option(app, settings.runs);
        add_number_option(app, "--threads", settings.threads, 1, 64, "Threads that compute");
        add_executor_option(app, settings.executor);
        add_layout_option(app, settings.layout);
        add_directory_option(app, settings.directory);
        add_json_option(app, settings.json);
      },
      [&] { return run(settings); }, &settings.directory);
}
