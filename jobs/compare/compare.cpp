#include "compare/compare.h"

#include <fmt/format.h>
#include <tbb/task_arena.h>

#include <system_error>

#include "compare/triangles.h"
#include "plait/error.h"
#include "plait/progress.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

TriangleSet triangles_of(const IndexedMesh& mesh) { return {mesh.positions, mesh.faces}; }

IndexedMesh read_side(const std::filesystem::path& path, const ComparisonRequest& request,
                      const BackendRegistry& backends, const JobWatch& watch) {
  std::error_code ignored;  // a path that cannot be looked at is a file that cannot be read
  const bool is_store = std::filesystem::is_directory(path, ignored);
  // Not reported as progress: nobody knows how long it takes. But a program may cancel here.
  if (watch.progress && !watch.progress({"read", 0, 0}))
    throw Error(ErrorCode::kCancelled, "compare: cancelled");
  return read_triangles(path, is_store ? request.level : -1, backends, watch.warn);
}

/// From `from` to `to`. `before`: samples of the other direction that are done.
Distances distances_of(const IndexedMesh& from, const IndexedMesh& to, std::string_view phase,
                       std::uint64_t before, const ComparisonRequest& request,
                       const JobWatch& watch) {
  DistanceOptions options{.samples = request.samples, .phase = phase};
  if (watch.progress)
    options.progress = [&](const Progress& now) {
      return watch.progress({now.phase, before + now.done, 2 * now.total});
    };
  const auto go_on = [&] {
    if (watch.progress && !watch.progress({phase, before, 2 * request.samples}))
      throw Error(ErrorCode::kCancelled, "compare: cancelled");
  };
  return measure_distances(triangles_of(from), TriangleTree(to.positions, to.faces, go_on),
                           triangles_of(to), options);
}

/// Warns of two surfaces that are nowhere near each other.
void check_boxes(const IndexedMesh& first, const IndexedMesh& second, const JobWatch& watch) {
  const SurfaceBox a = box_of(triangles_of(first)), b = box_of(triangles_of(second));
  bool apart = false;
  for (int axis = 0; axis < 3; ++axis)
    apart = apart || a.high[axis] < b.low[axis] || b.high[axis] < a.low[axis];
  if (!apart || !watch.warn) return;
  const auto text = [](const Point& p) { return fmt::format("({:g}, {:g}, {:g})", p.x, p.y, p.z); };
  watch.warn(
      fmt::format("the boxes of the two surfaces do not overlap: {} to {}, and {} to {}; do "
                  "they have the same units and the same origin?",
                  text(a.low), text(a.high), text(b.low), text(b.high)));
}

}  // namespace

SurfaceComparison compare_surfaces(const ComparisonRequest& request,
                                   const BackendRegistry& backends, const JobWatch& watch) {
  const IndexedMesh first = read_side(request.first, request, backends, watch);
  const IndexedMesh second = read_side(request.second, request, backends, watch);
  check_boxes(first, second, watch);
  SurfaceComparison result{
      diagonal_of(triangles_of(first)), mean_edge_of(triangles_of(first)), {}, {}};
  tbb::task_arena(thread_count(request.threads, "compare")).execute([&] {
    result.there = distances_of(first, second, "distance of A to B", 0, request, watch);
    result.back =
        distances_of(second, first, "distance of B to A", request.samples, request, watch);
  });
  return result;
}

PLAIT_END_NAMESPACE
