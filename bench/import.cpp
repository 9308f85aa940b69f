// How long does each step take from a mesh file to the order in which a store keeps the mesh?
//
//   plait_bench_import [--mesh FILE] [--runs 5] [--json FILE]
//
// The steps: reading with connectivity (read_base_mesh), the connectivity alone (BaseMesh::build),
// each order of faces, reordering the mesh, and the automatic choice (lay_out). The page cache is
// warm, and the number of threads is that of the machine. A turn runs each step once; the first
// turn does not count. Without --mesh the program takes an octahedron, refined in memory to 131072
// faces, and skips reading.
#include <fmt/format.h>

#include <functional>
#include <string>
#include <vector>

#include "command_line.h"
#include "plait/base_mesh.h"
#include "plait/kernels/subdivide.h"
#include "plait/layout.h"
#include "plait/mesh_io.h"
#include "support.h"

namespace {

using namespace plait;
using namespace plait::bench;

struct Settings {
  std::string mesh, json;
  int runs = 5;
};

struct Step {
  std::string name;
  std::function<double()> work;  ///< returns its seconds
  std::vector<double> seconds = {};
};

int run(const Settings& settings) {
  const BaseMesh base = settings.mesh.empty() ? octahedron(7) : read_base_mesh(settings.mesh);
  IndexedMesh indexed;
  indexed.positions.assign(base.positions().begin(), base.positions().end());
  indexed.faces.assign(base.faces().begin(), base.faces().end());
  const std::vector<FaceId> hilbert = face_order(base, LayoutKind::kHilbert);

  std::vector<Step> steps;
  const auto add = [&](const std::string& name, const auto& work) {
    steps.push_back({name, [work] { return seconds(work); }});
  };
  if (!settings.mesh.empty()) add("read and connect", [&] { read_base_mesh(settings.mesh); });
  steps.push_back({"connect", [&] {
                     IndexedMesh copy = indexed;
                     return seconds([&] { BaseMesh::build(std::move(copy)); });
                   }});
  for (const LayoutKind kind : {LayoutKind::kSpatial, LayoutKind::kHilbert, LayoutKind::kRcm})
    add(fmt::format("order, {}", to_string(kind)), [&, kind] { face_order(base, kind); });
  add("put in order", [&] { (void)base.with_face_order(hilbert); });
  add("measure spans", [&] { (void)measure_spans(base); });
  add("lay out, auto", [&] { (void)lay_out(base, LayoutKind::kAutomatic); });
  for (int turn = 0; turn <= settings.runs; ++turn)
    for (Step& step : steps) {
      const double time = step.work();
      if (turn > 0) step.seconds.push_back(time);
    }

  fmt::print("{} vertices, {} faces, {} runs\n\n| step | ms (min to max) |\n|---|---|\n",
             base.vertex_count(), base.face_count(), settings.runs);
  nlohmann::ordered_json rows;
  for (const Step& step : steps) {
    const Spread range = spread(step.seconds);
    fmt::print("| {} | {:.1f} ({:.1f} to {:.1f}) |\n", step.name, 1e3 * median(step.seconds),
               1e3 * range.smallest, 1e3 * range.largest);
    rows.push_back({{"name", step.name},
                    {"seconds", median(step.seconds)},
                    {"seconds_min", range.smallest},
                    {"seconds_max", range.largest}});
  }
  write_json(settings.json, {{"vertices", base.vertex_count()},
                             {"faces", base.face_count()},
                             {"runs", settings.runs},
                             {"steps", rows}});
  return 0;
}

}  // namespace

int main(int count, char** words) {
  Settings settings;
  return run_program(
      "plait_bench_import", "From a mesh's file to the order in which a store keeps it", count,
      words,
      [&](CommandLine& app) {
        add_mesh_option(app, settings.mesh, "an octahedron refined to 131,072 faces");
        add_runs_option(app, settings.runs);
        add_json_option(app, settings.json);
      },
      [&] { return run(settings); });
}
