#include "passes/surface_passes.h"

#include <fmt/format.h>

#include <span>
#include <string>
#include <tuple>

#include "base/default_arithmetic.h"
#include "normals/ring_normal.h"
#include "passes/noise.h"
#include "passes/position_box.h"
#include "plait/error.h"
#include "plait/extend/store_access.h"
#include "plait/progress.h"
#include "plait/visit_vertices.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// Calls pass(Real()) for the type of the positions' numbers.
template <class Pass>
auto with_real(const Store& store, const Pass& pass) {
  const AttributeId position = store.attribute("position");
  if (store.attributes()[position].schema.type == ComponentType::kFloat64) {
    StoreAccess::check_type(store, position, ComponentType::kFloat64, 3);
    return pass(double());
  }
  StoreAccess::check_type(store, position, ComponentType::kFloat32, 3);
  return pass(float());
}

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

void smooth_positions(Store& store, std::string_view into, double factor,
                      const VisitOptions& options) {
  with_real(store, [&]<class Real>(Real) {
    using Point = Vector3<Real>;
    visit_vertices(store, options, std::tuple{rings_of<Point>("position"), overwrites<Point>(into)},
                   [&](const VertexRun& run, const VertexRings<Point>& ring, std::span<Point> to) {
                     for (std::size_t i = 0; i < run.count; ++i) to[i] = smoothed(ring, i, factor);
                   });
  });
}

void add_noise(Store& store, std::string_view into, double length, std::uint64_t seed,
               const VisitOptions& options) {
  const Noise noise{store.base().edges(), length, seed};
  with_real(store, [&]<class Real>(Real) {
    using Point = Vector3<Real>;
    visit_vertices(store, options, std::tuple{reads<Point>("position"), overwrites<Point>(into)},
                   [&](const VertexRun& run, std::span<const Point> from, std::span<Point> to) {
                     noise.for_each(run, [&](std::size_t i, const Vector3<double>& way) {
                       to[i] = narrow<Real>(widen(from[i]) + way);
                     });
                   });
  });
}

void make_normals(Store& store, std::string_view into, const VisitOptions& options) {
  normals::BaseMasks masks;
  with_real(store, [&]<class Real>(Real) {
    visit_vertices(
        store, options,
        std::tuple{rings_of<Vector3<Real>>("position"), overwrites<Vector3<float>>(into)},
        [&](const VertexRun& run, const VertexRings<Vector3<Real>>& ring,
            std::span<Vector3<float>> to) {
          for (std::size_t i = 0; i < run.count; ++i)
            to[i] = normals::at_vertex(run, ring, i, masks);
        });
  });
}

double diagonal_of_positions(Store& store, const VisitOptions& options) {
  VisitOptions how = options;
  how.threads = thread_count(options.threads, "measure positions");
  const PositionBox box =
      with_real(store, [&]<class Real>(Real) { return measure_positions<Real>(store, how); });
  if (!box.finite || !box.has_extent())
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("measure positions of {}: expected finite ones in a box with an extent",
                            store.path().native()));
  return box.diagonal();
}

PLAIT_END_NAMESPACE
