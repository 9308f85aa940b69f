// Computes normals and limit positions, corners of patches, and base vertices.
#include "fused/surface_refiner.h"

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <span>
#include <utility>

#include "fused/patch_lattice.h"
#include "normals/normal_rules.h"
#include "plait/detail/numbers.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

using namespace lattice_points;

/// A point that a patch copies from the rings of a corner, because the stencil of the point goes
/// around the corner. Spoke 0 is along the side that starts at the corner. `next` and `previous`
/// are the steps from the corner towards the following and the preceding corner.
struct CornerPoint {
  RingPart ring;
  int spoke;
  std::int64_t next, previous;
};
using enum RingPart;
constexpr CornerPoint kCornerOfOneRing[] = {{kNear, -1, 1, -1}, {kNear, 2, -1, 1}};
// kFar matters only at level 1, where this point is the base vertex beyond a side. At finer levels,
// the rows of even vertices give the same point.
constexpr CornerPoint kCornerOfTwoRings[] = {
    {kNear, -1, 1, -1},   {kNear, 0, 1, 0},      {kNear, 1, 0, 1},
    {kNear, 2, -1, 1},    {kBetween, -2, 1, -2}, {kBetween, -1, 2, -1},
    {kBetween, 1, -1, 2}, {kBetween, 2, -2, 1},  {kFar, -1, 2, -2}};
std::span<const CornerPoint> corner_points(int ring_count) {
  if (ring_count == 1) return kCornerOfOneRing;
  return kCornerOfTwoRings;
}

}  // namespace

PatchLattice surface_lattice(int levels, int ring_count) {
  return {std::int64_t{1} << levels, ring_count};
}

template <class Real>
std::uint64_t surface_scratch_bytes(int levels, int ring_count) {
  return static_cast<std::uint64_t>(surface_lattice(levels, ring_count).points()) * kPointNumbers *
         (2 * sizeof(Real) + sizeof(float));
}

template <class Rule>
SurfaceRefiner<Rule>::SurfaceRefiner(const SurfaceRefinement<Rule>& refinement)
    : coarse_(surface_lattice(refinement.source.levels, Rule::kRingCount).points()),
      fine_(surface_lattice(refinement.source.levels, Rule::kRingCount).points()),
      refinement_(refinement),
      finest_(surface_lattice(refinement.source.levels, Rule::kRingCount)),
      rings_(refinement.source),
      normals_(refinement.results.normals.empty() ? 0 : finest_.points()) {
  static_assert(kMostCornerPoints == std::size(kCornerOfTwoRings));
}

template <class Rule>
const void* SurfaceRefiner<Rule>::points(std::size_t output) const {
  if (output == 0) return fine_.data();
  return normals_.data();
}

template <class Rule>
void SurfaceRefiner<Rule>::begin(std::span<const FaceId> faces) {
  faces_ = faces;
  rings_.evaluate(faces);
  if (!refinement_.results.positions.empty()) finish_base();
}

/// Stores the results of base vertices. The run that contains the first corner of a vertex stores
/// them.
template <class Rule>
void SurfaceRefiner<Rule>::finish_base() {
  const bool one_by_one = faces_.front() - faces_.back() == faces_.size() - 1;
  const BaseResults<Real>& results = refinement_.results;
  for (std::uint32_t number = 0; number < rings_.vertices().size(); ++number) {
    const VertexId vertex = rings_.vertices()[number];
    const FaceId face = refinement_.source.mesh.vertex_corners[vertex].face();
    if (face > faces_.front() || face < faces_.back()) continue;
    if (!one_by_one && !std::ranges::binary_search(faces_, face, std::ranges::greater())) continue;
    const auto view = rings_.view(number, refinement_.source.levels);
    const auto& [valence, border, ring_count] = view.shape;
    const auto neighbour = [&](int spoke) { return widen(view.neighbour(spoke)); };
    const Vector3<double> v = widen(view.vertex());
    results.positions[vertex] = view.vertex();
    if (!results.normals.empty())
      results.normals[vertex] = normals::of_base_vertex(masks_.of(valence, border), v, neighbour);
    if constexpr (Rule::kRingCount == 1) {
      if (results.limits.empty()) continue;
      BaseRing ring{valence, {}, neighbour(0), neighbour(valence - 1)};
      for (int i = 0; i < valence; ++i) ring.sum = ring.sum + neighbour(i);
      results.limits[vertex] = narrow<Real>(rule().limit_base(ring, border, v));
    }
  }
}

template <class Rule>
void SurfaceRefiner<Rule>::refine(std::size_t first, std::size_t count) {
  const int start = refinement_.source.first_level();
  find_corners(first, count);
  inject(start, count);
  for (int level = start + 1; level <= refinement_.source.levels; ++level) {
    std::swap(coarse_, fine_);
    refine_level(level, first, count);
  }
  make_surface();
  surface_borders(first, count);
  if (!refinement_.results.limits.empty()) std::swap(coarse_, fine_);
}

/// Finds the rings of the corners, and the places of the CornerPoints in these rings.
template <class Rule>
void SurfaceRefiner<Rule>::find_corners(std::size_t first, std::size_t count) {
  const RingSource<Rule>& source = refinement_.source;
  for (std::size_t lane = 0; lane < count; ++lane) {
    const auto turn = static_cast<std::size_t>(first_corner(source.mesh, faces_[first + lane]));
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const auto [number, spoke] = rings_.corner(faces_[first + lane], (corner + turn) % 3);
      const auto view = rings_.view(number, source.first_level());
      Corner& to = corners_[corner][lane];
      to.rings = view.first;
      to.level_numbers = view.shape.points() * kPointNumbers;
      std::size_t next = 0;
      for (const CornerPoint& point : corner_points(Rule::kRingCount))
        to.points[next++] = view.shape.point(point.ring, spoke + point.spoke) * kPointNumbers;
    }
  }
}

template <class Rule>
void SurfaceRefiner<Rule>::inject(int level, std::size_t count) {
  const PatchLattice lattice = this->lattice(level);
  for (int corner = 0; corner < 3; ++corner) {
    const FaceIndex here = corner_point(0, level, corner);
    const LatticeStep next = step((corner + 1) % 3, corner),
                      previous = step((corner + 2) % 3, corner);
    const std::span<Corner> lanes(corners_[static_cast<std::size_t>(corner)].data(), count);
    const auto copy = [&](Real* to, auto numbers_into_rings) {
      for (std::size_t lane = 0; lane < count; ++lane) {
        const Real* const from = lanes[lane].rings + numbers_into_rings(lanes[lane]);
        for (std::size_t axis = 0; axis < kPointNumbers; axis += kPatchLanes)
          to[axis + lane] = from[axis];
      }
    };
    copy(at(fine_.data(), lattice, here.i, here.j), [](const Corner&) { return std::size_t{0}; });
    std::size_t number = 0;
    for (const CornerPoint& point : corner_points(Rule::kRingCount)) {
      copy(at(fine_.data(), lattice, here.i + point.next * next.i + point.previous * previous.i,
              here.j + point.next * next.j + point.previous * previous.j),
           [number](const Corner& from) { return from.points[number]; });
      ++number;
    }
    for (Corner& from : lanes) from.rings += from.level_numbers;
  }
}

/// Computes normals, and limit positions, which it writes to `coarse_`.
template <class Rule>
void SurfaceRefiner<Rule>::make_surface() {
  const bool normals = !refinement_.results.normals.empty(),
             limits = !refinement_.results.limits.empty();
  if (!normals && !limits) return;
  const Real* positions = fine_.data();
  const auto row = [&](std::int64_t i, std::int64_t j, int side, std::int64_t step,
                       std::int64_t count) {
    const auto around = neighbours<Real>(positions, finest_, i, j, side);
    const Real* v = at(positions, finest_, i, j);
    if (normals) normal_row_({v, around, at(normals_.data(), finest_, i, j), step, count});
    if constexpr (Rule::kRingCount == 1)
      if (limits) rule().limit_row({v, around, at(coarse_.data(), finest_, i, j), step, count});
  };
  for (int level = 1; level <= refinement_.source.levels; ++level) {
    const std::int64_t size = std::int64_t{1} << level,
                       scale = std::int64_t{1} << (refinement_.source.levels - level);
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

template class SurfaceRefiner<OneRing<float>>;
template class SurfaceRefiner<OneRing<double>>;
template class SurfaceRefiner<Butterfly<float>>;
template class SurfaceRefiner<Butterfly<double>>;
template std::uint64_t surface_scratch_bytes<float>(int, int);
template std::uint64_t surface_scratch_bytes<double>(int, int);

PLAIT_END_NAMESPACE
