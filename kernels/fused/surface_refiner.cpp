#include "fused/surface_refiner.h"

#include <algorithm>
#include <new>
#include <utility>

#include "normals/normal_rules.h"
#include "plait/kernels/loop_base.h"

namespace plait {
namespace {

using fused_rows::kPointNumbers;
constexpr std::size_t kAlignment = 64;

template <class Number>
Number* at(Number* numbers, const PatchLattice& lattice, std::int64_t i, std::int64_t j) {
  return numbers + lattice.index(i, j) * static_cast<std::int64_t>(kPointNumbers);
}

/// One lane of a point.
template <class Number>
Vector3<Number> get(const Number* point, std::size_t lane) {
  return {point[lane], point[kPatchLanes + lane], point[2 * kPatchLanes + lane]};
}
template <class Number>
void put(Number* point, std::size_t lane, const Vector3<Number>& v) {
  point[lane] = v.x;
  point[kPatchLanes + lane] = v.y;
  point[2 * kPatchLanes + lane] = v.z;
}

struct Step {
  std::int64_t i, j;
};
/// The step that moves one unit of weight to corner `to` from corner `from`.
constexpr Step step(int to, int from) {
  return {std::int64_t(to == 1) - std::int64_t(from == 1),
          std::int64_t(to == 2) - std::int64_t(from == 2)};
}

/// The point of `side` with this weight at its start.
FaceIndex on_side(int level, int side, std::int64_t weight) {
  std::int64_t k[3] = {};
  k[(side + 1) % 3] = weight;
  k[(side + 2) % 3] = (std::int64_t{1} << level) - weight;
  return {0, level, k[1], k[2]};
}

/// The pairs of opposite neighbours in the order of the frame of `side`.
template <class Real>
fused_rows::Neighbours<Real> neighbours(const Real* numbers, const PatchLattice& lattice,
                                        std::int64_t i, std::int64_t j, int side) {
  const int start = (side + 1) % 3, end = (side + 2) % 3;
  const auto pair = [&](Step s, std::size_t which, fused_rows::Neighbours<Real>& to) {
    to.pairs[which][0] = at(numbers, lattice, i + s.i, j + s.j);
    to.pairs[which][1] = at(numbers, lattice, i - s.i, j - s.j);
  };
  fused_rows::Neighbours<Real> result;
  pair(step(start, side), 0, result);
  pair(step(end, side), 1, result);
  pair(step(end, start), 2, result);
  return result;
}

}  // namespace

template <class Number>
LatticeBuffer<Number>::LatticeBuffer(std::int64_t points) {
  const std::size_t count = static_cast<std::size_t>(points) * kPointNumbers;
  numbers_.reset(
      static_cast<Number*>(::operator new(count * sizeof(Number), std::align_val_t(kAlignment))));
  // Lanes without a patch, and beyond borders, are computed with and thrown away.
  std::fill_n(numbers_.get(), count, Number(0));
}
template <class Number>
void LatticeBuffer<Number>::Free::operator()(Number* numbers) const {
  ::operator delete(numbers, std::align_val_t(kAlignment));
}

template <class Real>
SurfaceRefiner<Real>::SurfaceRefiner(const SurfaceRefinement<Real>& refinement)
    : refinement_(refinement),
      finest_{std::int64_t{1} << refinement.levels, 1},
      fans_(refinement.mesh, refinement.base, refinement.levels, refinement.rows),
      coarse_(finest_.points()),
      fine_(finest_.points()),
      normals_(refinement.results.normals.empty() ? 0 : finest_.points()) {}

template <class Real>
std::uint64_t SurfaceRefiner<Real>::scratch_bytes(int levels) {
  const PatchLattice lattice{std::int64_t{1} << levels, 1};
  return static_cast<std::uint64_t>(lattice.points()) * kPointNumbers *
         (2 * sizeof(Real) + sizeof(float));
}

template <class Real>
const void* SurfaceRefiner<Real>::points(std::size_t output) const {
  if (output == 0) return fine_.data();
  return normals_.data();
}

template <class Real>
void SurfaceRefiner<Real>::begin(std::span<const FaceId> faces) {
  faces_ = faces;
  fans_.evaluate(faces);
  finish_base();
}

/// A base vertex belongs to the run that has its first corner.
template <class Real>
void SurfaceRefiner<Real>::finish_base() {
  const auto [lowest, highest] = std::ranges::minmax(faces_);
  const BaseResults<Real>& results = refinement_.results;
  for (std::uint32_t fan = 0; fan < fans_.vertices().size(); ++fan) {
    const VertexId vertex = fans_.vertices()[fan];
    const FaceId face = refinement_.mesh.vertex_corners[vertex].face();
    if (face < lowest || face > highest) continue;
    const auto view = fans_.view(fan, refinement_.levels);
    const Vector3<double> v = loop::widen(view.point(0));
    results.positions[vertex] = view.point(0);
    if (!results.normals.empty())
      results.normals[vertex] = normals::of_base_vertex(
          view.valence, view.border, v, [&](int i) { return loop::widen(view.point(1 + i)); });
    if (results.limits.empty()) continue;
    loop::BaseRing ring;
    ring.valence = view.valence;
    ring.first = loop::widen(view.point(1));
    ring.last = loop::widen(view.point(view.valence));
    for (int i = 1; i <= view.valence; ++i) ring.sum = ring.sum + loop::widen(view.point(i));
    results.limits[vertex] = loop::narrow<Real>(loop::limit_of_base(ring, view.border, v));
  }
}

template <class Real>
void SurfaceRefiner<Real>::refine(std::size_t first, std::size_t count) {
  find_corners(first, count);
  inject(0, count);
  for (int level = 1; level <= refinement_.levels; ++level) {
    std::swap(coarse_, fine_);
    make_odd(level);
    odd_borders(level, first, count);
    inject(level, count);
    move_even(level);
    even_borders(level, first, count);
  }
  make_surface();
  surface_borders(first, count);
  if (!refinement_.results.limits.empty()) std::swap(coarse_, fine_);
}

/// Finds the corners and, of their rings, the two points that no row reaches: next to the face's
/// own spokes in the faces beyond them. Where a border cuts one off the corner stands in.
template <class Real>
void SurfaceRefiner<Real>::find_corners(std::size_t first, std::size_t count) {
  for (std::size_t lane = 0; lane < count; ++lane) {
    const auto turn =
        static_cast<std::size_t>(first_corner(refinement_.mesh, faces_[first + lane]));
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const auto [fan, spoke] = fans_.corner(first + lane, (corner + turn) % 3);
      const auto view = fans_.view(fan, 0);
      const auto ring = [&](int number) -> std::size_t {
        if (view.border && (number < 0 || number >= view.valence)) return 0;
        if (number < 0) number += view.valence;
        if (number >= view.valence) number -= view.valence;
        return (1 + static_cast<std::size_t>(number)) * kPointNumbers;
      };
      corners_[corner][lane] = {view.first,
                                (1 + static_cast<std::size_t>(view.valence)) * kPointNumbers,
                                ring(spoke - 1), ring(spoke + 2)};
    }
  }
}

template <class Real>
void SurfaceRefiner<Real>::inject(int level, std::size_t count) {
  const PatchLattice lattice{std::int64_t{1} << level, 1};
  for (int corner = 0; corner < 3; ++corner) {
    const FaceIndex here = corner_point(0, level, corner);
    const Step before = step((corner + 1) % 3, (corner + 2) % 3);
    Real* const centre = at(fine_.data(), lattice, here.i, here.j);
    Real* const right = at(fine_.data(), lattice, here.i + before.i, here.j + before.j);
    Real* const left = at(fine_.data(), lattice, here.i - before.i, here.j - before.j);
    for (std::size_t lane = 0; lane < count; ++lane) {
      Corner& from = corners_[static_cast<std::size_t>(corner)][lane];
      for (std::size_t axis = 0; axis < kPointNumbers; axis += kPatchLanes) {
        centre[axis + lane] = from.fan[axis];
        right[axis + lane] = from.fan[from.right + axis];
        left[axis + lane] = from.fan[from.left + axis];
      }
      from.fan += from.level_numbers;
    }
  }
}

template <class Real>
void SurfaceRefiner<Real>::make_odd(int level) {
  const std::int64_t n = std::int64_t{1} << (level - 1);
  const PatchLattice coarse{n, 1}, fine{2 * n, 1};
  const auto from = [&](std::int64_t i, std::int64_t j) {
    return static_cast<const Real*>(at(coarse_.data(), coarse, i, j));
  };
  const auto to = [&](std::int64_t i, std::int64_t j) { return at(fine_.data(), fine, i, j); };
  // Fine rows 2q: middles of edges along the coarse row.
  for (std::int64_t q = 0; q <= n; ++q)
    refinement_.rows.odd(
        {from(-1, q), from(0, q), from(-1, q + 1), from(0, q - 1), to(-1, 2 * q), n - q + 2});
  // Fine rows 2q + 1: middles of edges that leave the coarse row upwards, in both directions.
  for (std::int64_t q = -1; q < n; ++q) {
    const std::int64_t first = q < 0 ? 1 : 0;
    refinement_.rows.odd({from(first, q), from(first, q + 1), from(first - 1, q + 1),
                          from(first + 1, q), to(2 * first, 2 * q + 1), q < 0 ? n : n - q + 1});
    refinement_.rows.odd({from(first, q), from(first - 1, q + 1), from(first - 1, q),
                          from(first, q + 1), to(2 * first - 1, 2 * q + 1), q < 0 ? n : n - q + 1});
  }
}

template <class Real>
void SurfaceRefiner<Real>::move_even(int level) {
  const std::int64_t n = std::int64_t{1} << (level - 1);
  const PatchLattice coarse{n, 1}, fine{2 * n, 1};
  for (std::int64_t q = 0; q < n; ++q) {
    const std::int64_t first = q == 0 ? 1 : 0, count = q == 0 ? n - 1 : n - q + 1;
    refinement_.rows.even({at(static_cast<const Real*>(coarse_.data()), coarse, first, q),
                           neighbours<Real>(fine_.data(), fine, 2 * first, 2 * q, 2),
                           at(fine_.data(), fine, 2 * first, 2 * q), count});
  }
}

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

/// Normals, and limit positions beside the positions in `coarse_`.
template <class Real>
void SurfaceRefiner<Real>::make_surface() {
  const bool normals = !refinement_.results.normals.empty(),
             limits = !refinement_.results.limits.empty();
  if (!normals && !limits) return;
  const Real* positions = fine_.data();
  const auto row = [&](std::int64_t i, std::int64_t j, int side, std::int64_t step,
                       std::int64_t count) {
    const auto around = neighbours<Real>(positions, finest_, i, j, side);
    const Real* v = at(positions, finest_, i, j);
    if (normals)
      refinement_.rows.normal({v, around, at(normals_.data(), finest_, i, j), step, count});
    if (limits) refinement_.rows.limit({v, around, at(coarse_.data(), finest_, i, j), step, count});
  };
  for (int level = 1; level <= refinement_.levels; ++level) {
    const std::int64_t size = std::int64_t{1} << level,
                       scale = std::int64_t{1} << (refinement_.levels - level);
    for (std::int64_t j = 0; j < size; ++j) {
      if (j % 2 == 0) {
        row(scale, j * scale, 2, 2 * scale, (size - j) / 2);
      } else {
        row(0, j * scale, 1, 2 * scale, (size - j + 1) / 2);
        row(scale, j * scale, 0, 2 * scale, (size - j + 1) / 2);
      }
    }
  }
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

template class LatticeBuffer<float>;
template class LatticeBuffer<double>;
template class SurfaceRefiner<float>;
template class SurfaceRefiner<double>;

}  // namespace plait
