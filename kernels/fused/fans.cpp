#include "fused/fans.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "plait/kernels/ring_table.h"

namespace plait {

using fused_rows::kPointNumbers;

template <class Real>
void Fans<Real>::evaluate(std::span<const FaceId> faces) {
  find(faces);
  place();
  fill_level_0();
  for (const Batch& batch : batches_) {
    const std::size_t level_numbers =
        (static_cast<std::size_t>(batch.valence) + 1) * kPointNumbers;
    for (int level = 0; level < levels_; ++level) {
      Real* from = points_.data() + batch.first + static_cast<std::size_t>(level) * level_numbers;
      rows_.fan({from, from + level_numbers, batch.valence, batch.border});
    }
  }
}

/// Numbers the vertices, and the corners of the faces around them.
template <class Real>
void Fans<Real>::find(std::span<const FaceId> faces) {
  vertices_.clear();
  fans_.clear();
  corners_.resize(faces.size());
  for (std::size_t face = 0; face < faces.size(); ++face)
    for (std::size_t side = 0; side < 3; ++side) {
      const VertexId vertex = mesh_.faces[faces[face]][side];
      if (fan_of_[vertex] == kNoId) {
        fan_of_[vertex] = static_cast<std::uint32_t>(vertices_.size());
        vertices_.push_back(vertex);
        const int valence = for_each_spoke(mesh_, vertex, [](EdgeId) {});
        fans_.push_back({0, valence, is_border_vertex(mesh_, vertex)});
      }
      corners_[face][side].fan = fan_of_[vertex];
    }
  for (const VertexId vertex : vertices_) fan_of_[vertex] = kNoId;

  // From the first corner of a vertex counterclockwise to the face: that many spokes.
  for (std::size_t face = 0; face < faces.size(); ++face)
    for (std::size_t side = 0; side < 3; ++side) {
      const FaceSide wanted(faces[face], static_cast<int>(side));
      Corner& corner = corners_[face][side];
      corner.spoke = 0;
      for (FaceSide at = mesh_.vertex_corners[vertices_[corner.fan]]; at != wanted;
           at = mesh_.next_corner(at))
        ++corner.spoke;
    }
}

/// Vertices of one kind share batches, and lanes left over repeat nothing: they stay as they are.
template <class Real>
void Fans<Real>::place() {
  std::vector<std::uint32_t> order(fans_.size());
  std::iota(order.begin(), order.end(), 0u);
  std::ranges::stable_sort(order, {}, [&](std::uint32_t fan) {
    return std::pair(fans_[fan].border, fans_[fan].valence);
  });
  batches_.clear();
  std::size_t end = 0, lane = kPatchLanes;
  for (const std::uint32_t number : order) {
    Fan& fan = fans_[number];
    const bool fits = lane < kPatchLanes && batches_.back().valence == fan.valence &&
                      batches_.back().border == fan.border;
    if (!fits) {
      batches_.push_back({end, fan.valence, fan.border});
      end += (static_cast<std::size_t>(fan.valence) + 1) * kPointNumbers *
             (static_cast<std::size_t>(levels_) + 1);
      lane = 0;
    }
    fan.first = batches_.back().first + lane++;
  }
  if (points_.size() < end) points_.resize(end);
}

template <class Real>
void Fans<Real>::fill_level_0() {
  for (std::size_t number = 0; number < fans_.size(); ++number) {
    Real* to = points_.data() + fans_[number].first;
    const auto put = [&](VertexId vertex) {
      for (int axis = 0; axis < 3; ++axis)
        to[static_cast<std::size_t>(axis) * kPatchLanes] = base_[vertex][axis];
      to += kPointNumbers;
    };
    const VertexId vertex = vertices_[number];
    put(vertex);
    for_each_spoke(mesh_, vertex, [&](EdgeId spoke) {
      const Edge& edge = mesh_.edges[spoke];
      put(edge.start == vertex ? edge.end : edge.start);
    });
  }
}

template <class Real>
typename Fans<Real>::View Fans<Real>::view(std::uint32_t number, int level) const {
  const Fan& fan = fans_[number];
  return {points_.data() + fan.first +
              static_cast<std::size_t>(level) * (static_cast<std::size_t>(fan.valence) + 1) *
                  kPointNumbers,
          fan.valence, fan.border};
}

template class Fans<float>;
template class Fans<double>;

}  // namespace plait
