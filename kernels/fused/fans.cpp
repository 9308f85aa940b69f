#include "fused/fans.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "fused/fan_border.h"
#include "fused/lattice_buffer.h"

namespace plait {
namespace {

using fused_rows::kPointNumbers;

/// A point of the fan that begins here, at its lane.
template <class Real>
void put(Real* fan, std::size_t point, const Vector3<Real>& v) {
  lattice_points::put(fan + point * kPointNumbers, 0, v);
}

}  // namespace

template <class Real>
void Fans<Real>::evaluate(std::span<const FaceId> faces) {
  find(faces);
  place();
  fill_first_level();
  for (const Batch& batch : batches_) {
    const std::size_t level_numbers = batch.shape.points() * kPointNumbers;
    Real* from = points_.data() + batch.first;
    for (int level = source_.first_level(); level < source_.levels; ++level, from += level_numbers)
      rows_.fan({from, from + level_numbers, batch.shape.valence, batch.shape.border});
  }
}

/// Numbers the vertices and walks around each once: its neighbours, and the faces of the run there.
template <class Real>
void Fans<Real>::find(std::span<const FaceId> faces) {
  vertices_.clear();
  fans_.clear();
  rings_.clear();
  corners_.resize(faces.size());
  const auto [lowest, highest] = std::ranges::minmax(faces);
  for (const FaceId face : faces)
    for (const VertexId vertex : source_.mesh.faces[face]) {
      if (fan_of_[vertex] != kNoId) continue;
      const auto number = fan_of_[vertex] = static_cast<std::uint32_t>(vertices_.size());
      vertices_.push_back(vertex);
      const std::size_t ring = rings_.size();
      const FaceSide first = source_.mesh.vertex_corners[vertex];
      bool border = false;
      int spoke = 0;
      for (FaceSide corner = first; spoke == 0 || corner != first; ++spoke) {
        const auto& of_face = source_.mesh.faces[corner.face()];
        const auto side = static_cast<std::size_t>(corner.side());
        rings_.push_back(of_face[(side + 1) % 3]);
        if (corner.face() >= lowest && corner.face() <= highest)
          corners_[highest - corner.face()][side] = {number, spoke};
        corner = source_.mesh.next_corner(corner);
        if (corner.exists()) continue;
        rings_.push_back(of_face[(side + 2) % 3]);
        border = true;
        break;
      }
      fans_.push_back({0, ring, {static_cast<int>(rings_.size() - ring), border, source_.reach()}});
    }
  for (const VertexId vertex : vertices_) fan_of_[vertex] = kNoId;
}

/// Vertices of one kind share batches, and lanes left over repeat nothing: they stay as they are.
template <class Real>
void Fans<Real>::place() {
  std::vector<std::uint32_t> order(fans_.size());
  std::iota(order.begin(), order.end(), 0u);
  const auto kind = [](const FanShape& shape) { return std::pair(shape.border, shape.valence); };
  std::ranges::stable_sort(order, {}, [&](std::uint32_t fan) { return kind(fans_[fan].shape); });
  const auto levels = static_cast<std::size_t>(source_.levels - source_.first_level() + 1);
  batches_.clear();
  std::size_t end = 0, lane = kPatchLanes;
  for (const std::uint32_t number : order) {
    Fan& fan = fans_[number];
    if (lane == kPatchLanes || kind(batches_.back().shape) != kind(fan.shape)) {
      batches_.push_back({end, fan.shape});
      end += fan.shape.points() * kPointNumbers * levels;
      lane = 0;
    }
    fan.first = batches_.back().first + lane++;
  }
  if (points_.size() < end) points_.resize(end);
}

template <class Real>
void Fans<Real>::fill_first_level() {
  for (std::uint32_t number = 0; number < fans_.size(); ++number) {
    Real* const to = points_.data() + fans_[number].first;
    const FanShape& shape = fans_[number].shape;
    put(to, 0, source_.base[vertices_[number]]);
    if (shape.reach > 1) {
      fill_two_rings(number);
      continue;
    }
    for (int spoke = 0; spoke < shape.valence; ++spoke)
      put(to, shape.first_neighbour() + static_cast<std::size_t>(spoke),
          source_.base[rings_[fans_[number].ring + static_cast<std::size_t>(spoke)]]);
  }
  if (source_.reach() == 1) return;
  for (const Batch& batch : batches_)
    if (batch.shape.border)
      butterfly::continue_fan(batch.shape.valence, points_.data() + batch.first);
}

/// At level 1: middles of the spokes, their other ends, and middles of the edges between these.
template <class Real>
void Fans<Real>::fill_two_rings(std::uint32_t number) {
  using enum FanRing;
  const auto& [first, ring, shape] = fans_[number];
  Real* const to = points_.data() + first;
  FaceSide corner = source_.mesh.vertex_corners[vertices_[number]];
  for (int spoke = 0; spoke < shape.valence; ++spoke) {
    put(to, shape.point(kFar, spoke), source_.base[rings_[ring + static_cast<std::size_t>(spoke)]]);
    const bool last_of_border = shape.border && spoke == shape.valence - 1;
    const auto& edges = source_.mesh.face_edges[corner.face()];
    const auto side = static_cast<std::size_t>(corner.side());
    put(to, shape.point(kNear, spoke),
        source_.middles[edges[(side + (last_of_border ? 1 : 2)) % 3]]);
    if (last_of_border) return;
    put(to, shape.point(kBetween, spoke), source_.middles[edges[side]]);
    const FaceSide next = source_.mesh.next_corner(corner);
    if (next.exists()) corner = next;
  }
}

template <class Real>
typename Fans<Real>::View Fans<Real>::view(std::uint32_t number, int level) const {
  const Fan& fan = fans_[number];
  return {points_.data() + fan.first +
              static_cast<std::size_t>(level - source_.first_level()) * fan.shape.points() *
                  kPointNumbers,
          fan.shape};
}

template class Fans<float>;
template class Fans<double>;

}  // namespace plait
