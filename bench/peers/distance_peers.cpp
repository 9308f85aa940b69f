// Does plait measure the same distances between two surfaces as another library?
//
//   plait_bench_distance_peers [--mesh FILE --other FILE] [--samples 1000000]
//
// Without files it takes two spheres of triangles, a fine one and a coarse one. CGAL chooses points
// of its own, so equal distances are no accident of the points. Fails if the root mean square, the
// mean or the 99th percentile differ by more than 2 %.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <vector>

#include "distance/closest_point.h"
#include "distance/distances.h"
#include "instrument/statistics.h"
#include "micro/command_line.h"
#include "micro/support.h"
#include "peers/peer.h"
#include "plait/error.h"
#include "plait/mesh_io.h"

namespace {

using namespace plait;
using namespace plait::bench;

constexpr double kMostDifference = 0.02;

IndexedMesh sphere(int refinements) {
  const BaseMesh base = octahedron(refinements);
  IndexedMesh mesh{{base.positions().begin(), base.positions().end()},
                   {base.faces().begin(), base.faces().end()}};
  for (Vector3<double>& p : mesh.positions) p = normalized(p);
  return mesh;
}

void run(const Settings& settings) {
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
    const std::vector<double> theirs = cgal_distances(from, to, samples);
    const auto row = [&](const char* name, double value, double peer) {
      const double difference = std::abs(value - peer) / peer;
      most = std::max(most, difference);
      table.add({direction, name},
                {100 * value / diagonal, 100 * peer / diagonal, 100 * difference});
    };
    const double squares = std::inner_product(theirs.begin(), theirs.end(), theirs.begin(), 0.0);
    row("root mean square", mine.rms, std::sqrt(squares / static_cast<double>(samples)));
    row("mean", mine.mean, instrument::mean_interval(theirs).value);
    row("99th percentile", mine.percentile_99, instrument::quantile(theirs, 0.99));
  };
  add("mesh to other", first, second);
  add("other to mesh", second, first);
  table.print(fmt::format("{} points on each surface, {} and {} faces", settings.samples,
                          first.faces.size(), second.faces.size()));
  if (!(most <= kMostDifference))
    throw Error(ErrorCode::kCorruption,
                fmt::format("the distances differ by {:.2f} %, expected at most {:.0f} %",
                            100 * most, 100 * kMostDifference));
}

}  // namespace

int main(int count, char** words) {
  return Program("plait_bench_distance_peers",
                 "Distances between two surfaces, by plait and by CGAL", {},
                 {"--mesh", "--other", "--samples"})
      .run(count, words, run);
}
