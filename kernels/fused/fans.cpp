#include "fused/fans.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace plait {

using fused_rows::kPointNumbers;

template <class Real>
void Fans<Real>::evaluate(std::span<const FaceId> faces) {
  find(faces);
  place();
  fill_level_0();
  for (const Batch& batch : batches_) {
    const std::size_t level_numbers = (static_cast<std::size_t>(batch.valence) + 1) * kPointNumbers;
    for (int level = 0; level < levels_; ++level) {
      Real* from = points_.data() + batch.first + static_cast<std::size_t>(level) * level_numbers;
      rows_.fan({from, from + level_numbers, batch.valence, batch.border});
    }
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
    for (const VertexId vertex : mesh_.faces[face]) {
      if (fan_of_[vertex] != kNoId) continue;
      const auto number = fan_of_[vertex] = static_cast<std::uint32_t>(vertices_.size());
      vertices_.push_back(vertex);
      const std::size_t ring = rings_.size();
      const FaceSide first = mesh_.vertex_corners[vertex];
      bool border = false;
      int spoke = 0;
      for (FaceSide corner = first; spoke == 0 || corner != first; ++spoke) {
        const auto& of_face = mesh_.faces[corner.face()];
        const auto side = static_cast<std::size_t>(corner.side());
        rings_.push_back(of_face[(side + 1) % 3]);
        if (corner.face() >= lowest && corner.face() <= highest)
          corners_[highest - corner.face()][side] = {number, spoke};
        corner = mesh_.next_corner(corner);
        if (corner.exists()) continue;
        rings_.push_back(of_face[(side + 2) % 3]);
        border = true;
        break;
      }
      fans_.push_back({0, ring, static_cast<int>(rings_.size() - ring), border});
    }
  for (const VertexId vertex : vertices_) fan_of_[vertex] = kNoId;
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
    put(vertices_[number]);
    for (std::size_t i = 0; i < static_cast<std::size_t>(fans_[number].valence); ++i)
      put(rings_[fans_[number].ring + i]);
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
