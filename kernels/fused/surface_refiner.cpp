#include "fused/surface_refiner.h"

#include <algorithm>
#include <utility>

#include "normals/normal_rules.h"
#include "plait/kernels/loop_base.h"

namespace plait {
namespace {

using fused_rows::kPointNumbers;
using namespace lattice_points;

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

template class SurfaceRefiner<float>;
template class SurfaceRefiner<double>;

}  // namespace plait
