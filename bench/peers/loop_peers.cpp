// How fast are the positions of a Loop surface computed in memory, compared with other libraries?
//
//   plait_bench_loop_peers [--mesh FILE] [--level 4] [--runs 5]
//
// Without --mesh it takes an octahedron, refined in memory to 8192 faces. All libraries get the
// same faces in the same order, one thread, and memory that was touched before: plait uses a
// backend that keeps its pages, the others use a heap that returns no pages to the system. Times
// are processor times of the thread, so that other programs on the machine affect them little. A
// turn runs each library twice and measures the second run, and ratios are computed within a turn.
// Before the turns, all surfaces must agree, and memory is measured, with a process for each
// library.
#include <fmt/format.h>
#include <malloc.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "instrument/process.h"
#include "micro/command_line.h"
#include "micro/recycled_memory.h"
#include "micro/support.h"
#include "peers/surfaces.h"
#include "plait/error.h"
#include "plait/layout.h"
#include "plait/store.h"

namespace {

using namespace plait;
using namespace plait::bench;

/// plait itself. The connectivity and the order of the faces, which a program computes once per
/// mesh, are in the time only if `preparation_too`.
Peer plait_peer(RecycledPages& pages, bool preparation_too) {
  return {"plait", preparation_too ? "fused executor, connectivity and order" : "fused executor",
          [&pages, preparation_too](const BaseMesh& base, int level, Points* points) {
            const BackendRegistry backends = recycled_memory(pages);
            IndexedMesh given{{base.positions().begin(), base.positions().end()},
                              {base.faces().begin(), base.faces().end()}};
            BaseMesh mesh = base;
            const double preparation = !preparation_too ? 0 : thread_seconds([&] {
              tbb::task_arena(1).execute([&] {
                mesh = lay_out(BaseMesh::build(std::move(given)), LayoutKind::kHilbert).mesh;
              });
            });
            Store store = recycled_store(std::move(mesh), backends);
            const SubdivideOptions how{.executor = ExecutorKind::kFused, .levels = level};
            const double result = thread_seconds([&] { subdivide(store, how); });
            if (points != nullptr) *points = positions_of(store);
            return result + preparation;
          }};
}

[[maybe_unused]] void add(std::vector<Peer>& to, std::vector<Peer> peers) {
  to.insert(to.end(), peers.begin(), peers.end());
}

std::vector<Peer> all_peers(RecycledPages& pages) {
  std::vector<Peer> peers = {plait_peer(pages, false), plait_peer(pages, true)};
#ifdef PLAIT_BENCH_OPEN_SUBDIV
  add(peers, open_subdiv_peers());
#endif
#ifdef PLAIT_BENCH_CGAL
  add(peers, cgal_peers());
#endif
#ifdef PLAIT_BENCH_OPEN_MESH
  add(peers, open_mesh_peers());
#endif
  return peers;
}

using Coordinates = std::array<std::vector<float>, 3>;

/// The coordinates of each axis, sorted. Equal surfaces give equal lists, whatever the order of
/// their vertices.
Coordinates sorted_coordinates(const Points& points) {
  Coordinates axes;
  for (std::size_t axis = 0; axis < axes.size(); ++axis) {
    for (const Vector3<float>& point : points) axes[axis].push_back(point[static_cast<int>(axis)]);
    std::ranges::sort(axes[axis]);
  }
  return axes;
}

constexpr double kTolerance = 1e-4;  // in diagonals of the bounding box

/// Throws kCorruption naming a library whose surface differs from that of the first.
void check_agreement(const std::vector<Peer>& peers, const BaseMesh& base, int level) {
  const std::uint64_t vertices = counts_at_level(base, level).vertices;
  const auto surface = [&](const Peer& peer) {
    Points points;
    peer.refine(base, level, &points);
    if (points.size() != vertices)
      throw Error(ErrorCode::kCorruption, fmt::format("{}, {}: {} vertices, expected {}", peer.name,
                                                      peer.measured, points.size(), vertices));
    return sorted_coordinates(points);
  };
  const Coordinates expected = surface(peers.front());
  const auto width = [&](std::size_t axis) {
    return double{expected[axis].back()} - double{expected[axis].front()};
  };
  const double diagonal = std::hypot(width(0), width(1), width(2));
  for (const Peer& peer : peers) {
    const Coordinates found = surface(peer);
    double largest = 0;
    for (std::size_t axis = 0; axis < found.size(); ++axis)
      for (std::size_t i = 0; i < vertices; ++i)
        largest = std::max(largest, std::abs(double{found[axis][i]} - double{expected[axis][i]}));
    if (!(largest <= kTolerance * diagonal))
      throw Error(ErrorCode::kCorruption,
                  fmt::format("{}, {}: differs by {} of the diagonal, expected at most {}",
                              peer.name, peer.measured, largest / diagonal, kTolerance));
  }
}

LaidOutMesh load(const Settings& settings) {
  return mesh_or_octahedron(settings.mesh, 5, LayoutKind::kHilbert);
}

std::uint64_t peak_of(const Settings& settings, std::size_t which) {
  return instrument::in_own_process([&] {
    RecycledPages pages;
    const std::vector<Peer> peers = all_peers(pages);
    const LaidOutMesh base = load(settings);
    const instrument::PeakMemory peak;
    peers[which].refine(base.mesh, settings.level, nullptr);
    return peak.bytes();
  });
}

void run(const Settings& settings) {
  RecycledPages pages;
  const std::vector<Peer> peers = all_peers(pages);
  std::vector<std::uint64_t> peaks;
  for (std::size_t i = 0; i < peers.size(); ++i) {
    say_progress(fmt::format("memory: {}, {}", peers[i].name, peers[i].measured));
    peaks.push_back(peak_of(settings, i));
  }

  ::mallopt(M_MMAP_MAX, 0);
  ::mallopt(M_TRIM_THRESHOLD, std::numeric_limits<int>::max());
  const LaidOutMesh base = load(settings);
  check_agreement(peers, base.mesh, settings.level);
  const auto vertices = static_cast<double>(counts_at_level(base.mesh, settings.level).vertices);
  Measurements table(
      "library|measured",
      {{"thread ns a vertex", 2, true}, {"over plait", 1, true}, {"peak bytes a vertex", 0}});
  for (int turn = 0; turn < settings.runs; ++turn) {
    double first = 0;
    for (std::size_t i = 0; i < peers.size(); ++i) {
      say_progress(fmt::format("turn {} of {}: {}, {}", turn + 1, settings.runs, peers[i].name,
                               peers[i].measured));
      // An extra run, not measured: it removes what the library before left in the caches and in
      // the heap.
      peers[i].refine(base.mesh, settings.level, nullptr);
      const double time = peers[i].refine(base.mesh, settings.level, nullptr);
      if (i == 0) first = time;
      table.add({peers[i].name, peers[i].measured},
                {1e9 / vertices * time, time / first, static_cast<double>(peaks[i]) / vertices});
    }
  }
  table.print(
      fmt::format("{} base vertices, {} at level {}, positions only, one thread, layout hilbert, "
                  "{} runs",
                  base.mesh.vertex_count(), vertices, settings.level, settings.runs));
}

}  // namespace

int main(int count, char** words) {
  return Program("plait_bench_loop_peers",
                 "Positions of Loop surfaces in memory, plait and other libraries", {.level = 4},
                 {"--mesh", "--level", "--runs"})
      .run(count, words, run);
}
