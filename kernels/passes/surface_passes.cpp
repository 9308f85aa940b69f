#include "passes/surface_passes.h"

#include <fmt/format.h>

#include <span>
#include <string>
#include <tuple>

#include "base/default_arithmetic.h"
#include "normals/ring_normal.h"
#include "passes/moved_positions.h"
#include "passes/noise.h"
#include "plait/error.h"
#include "plait/progress.h"
#include "plait/visit_vertices.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// In double, in the order of the ring.
template <class Real>
Vector3<Real> smoothed(const VertexRings<Vector3<Real>>& ring, std::size_t i, double factor) {
  const Vector3<double> vertex = widen(ring.vertex(i));
  Vector3<double> sum{};
  // On a border only its neighbours there, which come first and last: so the border stays a curve.
  const int step = ring.is_border() ? ring.valence() - 1 : 1;
  int count = 0;
  for (int k = 0; k < ring.valence(); k += step, ++count) sum = sum + widen(ring.neighbour(i, k));
  return narrow<Real>(vertex + factor * (1.0 / count * sum - vertex));
}

}  // namespace

Moves smooth_positions(Store& store, std::string_view into, double factor,
                       const VisitOptions& options) {
  MovesOfVisit moves(options);
  with_real(store, [&]<class Real>(Real) {
    using Point = Vector3<Real>;
    visit_vertices(store, options, std::tuple{rings_of<Point>("position"), overwrites<Point>(into)},
                   [&](const VertexRun& run, const VertexRings<Point>& ring, std::span<Point> to) {
                     for (std::size_t i = 0; i < run.count; ++i) {
                       to[i] = smoothed(ring, i, factor);
                       moves.add(run, widen(to[i]) - widen(ring.vertex(i)));
                     }
                   });
  });
  return moves.sum();
}

Moves add_noise(Store& store, std::string_view into, double length, std::uint64_t seed,
                const VisitOptions& options) {
  MovesOfVisit moves(options);
  const Noise noise{store.base().edges(), length, seed};
  with_real(store, [&]<class Real>(Real) {
    using Point = Vector3<Real>;
    visit_vertices(store, options, std::tuple{reads<Point>("position"), overwrites<Point>(into)},
                   [&](const VertexRun& run, std::span<const Point> from, std::span<Point> to) {
                     noise.for_each(run, [&](std::size_t i, const Vector3<double>& way) {
                       to[i] = narrow<Real>(widen(from[i]) + way);
                       moves.add(run, widen(to[i]) - widen(from[i]), way);
                     });
                   });
  });
  return moves.sum();
}

void make_normals(Store& store, std::string_view positions, std::string_view into,
                  const VisitOptions& options) {
  normals::BaseMasks masks;
  with_real(store, [&]<class Real>(Real) {
    visit_vertices(store, options,
                   std::tuple{rings_of<Vector3<Real>>(positions), overwrites<Vector3<float>>(into)},
                   [&](const VertexRun& run, const VertexRings<Vector3<Real>>& ring,
                       std::span<Vector3<float>> to) {
                     for (std::size_t i = 0; i < run.count; ++i)
                       to[i] = normals::at_vertex(run, ring, i, masks);
                   });
  });
}

PositionBox box_of_positions(Store& store, const VisitOptions& options) {
  VisitOptions how = options;
  how.threads = thread_count(options.threads, "measure positions");
  const PositionBox box =
      with_real(store, [&]<class Real>(Real) { return measure_positions<Real>(store, how); });
  const auto refuse = [&](const char* reason) {
    return Error(ErrorCode::kInvalidArgument,
                 fmt::format("measure positions of {}: {}", store.path().native(), reason));
  };
  if (!box.finite) throw refuse("a position is not finite");
  if (!box.has_extent())
    throw refuse("their bounding box has no extent, or none that a number can hold");
  return box;
}

PLAIT_END_NAMESPACE
