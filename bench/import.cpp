// How long does a mesh take from its file to the order in which a store keeps it, step by step?
//
//   plait_bench_import [--mesh FILE] [--runs 5] [--json]
//
// Reading with connectivity (read_base_mesh), of which the connectivity alone (BaseMesh::build),
// each order of faces, putting the mesh into one, and the automatic choice (lay_out). Warm page
// cache, as many threads as the machine has. Steps alternate; one turn before the counted ones.
// Without a mesh: an octahedron, refined in memory to 131072 faces, and no reading.
#include <fmt/format.h>

#include <functional>
#include <string>
#include <vector>

#include "plait/base_mesh.h"
#include "plait/error.h"
#include "plait/kernels/subdivide.h"
#include "plait/layout.h"
#include "plait/mesh_io.h"
#include "support.h"

namespace {

using namespace plait;
using namespace plait::bench;

struct Settings {
  std::string mesh;
  int runs = 5;
  bool json = false;
};

struct Step {
  std::string name;
  std::function<double()> work;  ///< returns its seconds
  std::vector<double> seconds = {};
};

void run(const Settings& settings) {
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

  if (settings.json) {
    fmt::print("{{\"vertices\": {}, \"faces\": {}, \"runs\": {}, \"steps\": [", base.vertex_count(),
               base.face_count(), settings.runs);
    for (const Step& step : steps) {
      const Spread range = spread(step.seconds);
      fmt::print(
          "{}{{\"name\": \"{}\", \"seconds\": {}, \"seconds_min\": {}, \"seconds_max\": {}}}",
          &step == &steps.front() ? "" : ", ", step.name, median(step.seconds), range.smallest,
          range.largest);
    }
    fmt::print("]}}\n");
    return;
  }
  fmt::print("{} vertices, {} faces, {} runs\n\n| step | ms (min to max) |\n|---|---|\n",
             base.vertex_count(), base.face_count(), settings.runs);
  for (const Step& step : steps) {
    const Spread range = spread(step.seconds);
    fmt::print("| {} | {:.1f} ({:.1f} to {:.1f}) |\n", step.name, 1e3 * median(step.seconds),
               1e3 * range.smallest, 1e3 * range.largest);
  }
}

Settings parse(int count, char** words) {
  Settings settings;
  for (int i = 1; i < count; ++i) {
    const std::string_view name = words[i];
    if (name == "--json") {
      settings.json = true;
      continue;
    }
    const std::string value = i + 1 < count ? words[++i] : "";
    if (name == "--mesh" && !value.empty())
      settings.mesh = value;
    else if (name == "--runs")
      settings.runs = std::stoi(value);
    else
      throw Error(ErrorCode::kInvalidArgument, fmt::format("what is '{}'?", name));
  }
  if (settings.runs < 1) throw Error(ErrorCode::kInvalidArgument, "expected runs of at least 1");
  return settings;
}

}  // namespace

int main(int count, char** words) {
  try {
    run(parse(count, words));
    return 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "plait_bench_import: {}\n", error.what());
    return 1;
  }
}
