// Does plait measure the same distances between two surfaces as another library?
//
//   plait_bench_distance_peers [--mesh FILE --other FILE] [--samples 1000000]
//
// Without files it takes two spheres of triangles, a fine one and a coarse one. CGAL chooses points
// of its own, so equal distances are no accident of the points. Fails if the root mean square, the
// mean or the 99th percentile differ by more than 2 %. The largest distance depends on single
// points, so it is only shown. Without CGAL there is nothing to compare, and the program says so.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>

#include "distance/closest_point.h"
#include "distance/distances.h"
#include "micro/command_line.h"
#include "micro/support.h"
#include "peers/distance_peer.h"
#include "plait/error.h"
#include "plait/mesh_io.h"

namespace {

using namespace plait;
using namespace plait::bench;

struct Settings {
  std::string mesh, other;
  int samples = 1000000;
};

#ifdef PLAIT_BENCH_CGAL
constexpr double kMostDifference = 0.02;

IndexedMesh sphere(int refinements) {
  const BaseMesh base = octahedron(refinements);
  IndexedMesh mesh{{base.positions().begin(), base.positions().end()},
                   {base.faces().begin(), base.faces().end()}};
  for (Vector3<double>& p : mesh.positions) p = normalized(p);
  return mesh;
}

int run(const Settings& settings) {
  if (settings.mesh.empty() != settings.other.empty())
    throw Error(ErrorCode::kInvalidArgument, "expected --mesh and --other, or neither");
  const bool own = settings.mesh.empty();
  const IndexedMesh first = own ? sphere(6) : read_indexed_mesh(settings.mesh),
                    second = own ? sphere(3) : read_indexed_mesh(settings.other);
  const auto samples = static_cast<std::uint64_t>(settings.samples);
  const double diagonal = diagonal_of({first.positions, first.faces});

  Measurements table(
      "direction|measured",
      {{"plait, % of the diagonal", 5}, {"CGAL, % of the diagonal", 5}, {"difference, %"}});
  double most = 0;
  const auto add = [&](const char* direction, const IndexedMesh& from, const IndexedMesh& to) {
    const Distances mine =
        measure_distances({from.positions, from.faces}, TriangleTree(to.positions, to.faces),
                          {to.positions, to.faces}, {.samples = samples});
    const PeerDistances theirs = cgal_distances(from, to, samples);
    const auto row = [&](const char* name, double value, double peer, bool counts) {
      const double difference = std::abs(value - peer) / peer;
      if (counts) most = std::max(most, difference);
      table.add({direction, name},
                {100 * value / diagonal, 100 * peer / diagonal, 100 * difference});
    };
    row("root mean square", mine.rms, theirs.rms, true);
    row("mean", mine.mean, theirs.mean, true);
    row("99th percentile", mine.percentile_99, theirs.percentile_99, true);
    row("max", mine.max, theirs.max, false);
  };
  add("mesh to other", first, second);
  add("other to mesh", second, first);
  table.print(fmt::format("{} points on each surface, {} and {} faces", settings.samples,
                          first.faces.size(), second.faces.size()));
  if (!(most <= kMostDifference))
    throw Error(ErrorCode::kCorruption,
                fmt::format("the distances differ by {:.2f} %, expected at most {:.0f} %",
                            100 * most, 100 * kMostDifference));
  return 0;
}
#else
int run(const Settings&) {
  fmt::print("CGAL was not found: nothing to compare\n");
  return 0;
}
#endif

}  // namespace

int main(int count, char** words) {
  Settings settings;
  Program program("plait_bench_distance_peers",
                  "Distances between two surfaces, by plait and by CGAL");
  program.mesh(settings.mesh, "a sphere of 32,768 triangles")
      .number("--samples", settings.samples, 1000, 100000000, "Points on each surface");
  program.options().add_option("--other", settings.other,
                               "Another mesh; default: a sphere of 512 triangles");
  return program.run(count, words, [&] { return run(settings); });
}
