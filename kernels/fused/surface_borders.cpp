// What a group of patches does differently along border edges: curves of their own, lane by lane,
// over what the rows computed there.
#include "fused/surface_refiner.h"
#include "normals/normal_rules.h"
#include "plait/kernels/loop_base.h"

namespace plait {
namespace {

using namespace lattice_points;

/// The point of `side` with this weight at its start.
FaceIndex on_side(int level, int side, std::int64_t weight) {
  std::int64_t k[3] = {};
  k[(side + 1) % 3] = weight;
  k[(side + 2) % 3] = (std::int64_t{1} << level) - weight;
  return {0, level, k[1], k[2]};
}

}  // namespace

/// Calls visit(lane, side) for the sides that lie on a border.
template <class Real>
template <class Visit>
void SurfaceRefiner<Real>::for_each_border(std::size_t first, std::size_t count,
                                           Visit visit) const {
  if (refinement_.mesh.border_edges.empty()) return;
  for (std::size_t lane = 0; lane < count; ++lane) {
    const FaceId face = faces_[first + lane];
    const int turn = first_corner(refinement_.mesh, face);
    for (int side = 0; side < 3; ++side)
      if (!refinement_.mesh.across(FaceSide(face, (side + turn) % 3)).exists()) visit(lane, side);
  }
}

template <class Real>
void SurfaceRefiner<Real>::odd_borders(int level, std::size_t first, std::size_t count) {
  const std::int64_t n = std::int64_t{1} << (level - 1);
  const PatchLattice coarse{n, 1}, fine{2 * n, 1};
  for_each_border(first, count, [&](std::size_t lane, int side) {
    for (std::int64_t t = 0; t < n; ++t) {
      const FaceIndex a = on_side(level - 1, side, t), b = on_side(level - 1, side, t + 1),
                      middle = on_side(level, side, 2 * t + 1);
      put(at(fine_.data(), fine, middle.i, middle.j), lane,
          Real(0.5) * (get(at(coarse_.data(), coarse, a.i, a.j), lane) +
                       get(at(coarse_.data(), coarse, b.i, b.j), lane)));
    }
  });
}

template <class Real>
void SurfaceRefiner<Real>::even_borders(int level, std::size_t first, std::size_t count) {
  const std::int64_t n = std::int64_t{1} << (level - 1);
  const PatchLattice coarse{n, 1}, fine{2 * n, 1};
  for_each_border(first, count, [&](std::size_t lane, int side) {
    for (std::int64_t t = 1; t < n; ++t) {
      const FaceIndex old = on_side(level - 1, side, t), a = on_side(level, side, 2 * t - 1),
                      here = on_side(level, side, 2 * t), b = on_side(level, side, 2 * t + 1);
      put(at(fine_.data(), fine, here.i, here.j), lane,
          refinement_.rows.border(get(at(coarse_.data(), coarse, old.i, old.j), lane),
                                  get(at(fine_.data(), fine, a.i, a.j), lane),
                                  get(at(fine_.data(), fine, b.i, b.j), lane)));
    }
  });
}

template <class Real>
void SurfaceRefiner<Real>::surface_borders(std::size_t first, std::size_t count) {
  const bool normals = !refinement_.results.normals.empty(),
             limits = !refinement_.results.limits.empty();
  if (!normals && !limits) return;
  for_each_border(first, count, [&](std::size_t lane, int side) {
    const int start = (side + 1) % 3, end = (side + 2) % 3;
    for (std::int64_t t = 1; t < finest_.size; ++t) {
      const FaceIndex here = on_side(refinement_.levels, side, t);
      const auto near = [&](Step s) {
        return get(at(static_cast<const Real*>(fine_.data()), finest_, here.i + s.i, here.j + s.j),
                   lane);
      };
      const Vector3<Real> v = near({0, 0}), p1 = near(step(end, start)),
                          p4 = near(step(start, end));
      if (normals)
        put(at(normals_.data(), finest_, here.i, here.j), lane,
            normals::regular_border(v, p1, near(step(side, start)), near(step(side, end)), p4));
      if (limits)
        put(at(coarse_.data(), finest_, here.i, here.j), lane,
            loop::by_axis<Real>(loop::limit_border<Real>, v, p1, p4));
    }
  });
}

template void SurfaceRefiner<float>::odd_borders(int, std::size_t, std::size_t);
template void SurfaceRefiner<double>::odd_borders(int, std::size_t, std::size_t);
template void SurfaceRefiner<float>::even_borders(int, std::size_t, std::size_t);
template void SurfaceRefiner<double>::even_borders(int, std::size_t, std::size_t);
template void SurfaceRefiner<float>::surface_borders(std::size_t, std::size_t);
template void SurfaceRefiner<double>::surface_borders(std::size_t, std::size_t);

}  // namespace plait
