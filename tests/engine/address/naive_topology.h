// A Topology built the plainest way, so that edge indices are tested without the library's own
// mesh code.
#pragma once

#include <array>
#include <map>
#include <utility>
#include <vector>

#include "plait/base_mesh.h"
#include "plait/extend/topology.h"

namespace plait::test {

class NaiveTopology {
 public:
  explicit NaiveTopology(const IndexedMesh& mesh)
      : faces_(mesh.faces), corners_(mesh.positions.size()) {
    std::map<std::pair<VertexId, VertexId>, FaceSide> half_edges;
    for (FaceId f = 0; f < faces_.size(); ++f)
      for (int side = 0; side < 3; ++side)
        half_edges[{corner(f, side + 1), corner(f, side + 2)}] = FaceSide(f, side);

    face_edges_.resize(faces_.size());
    for (const auto& [ends, side] : half_edges) {
      const auto beyond = half_edges.find({ends.second, ends.first});
      if (beyond == half_edges.end()) {
        border_edges_.push_back(static_cast<EdgeId>(edges_.size()));
      } else if (ends.first > ends.second) {
        continue;
      }
      const FaceSide other = beyond == half_edges.end() ? FaceSide() : beyond->second;
      for (const FaceSide at : {side, other})
        if (at.exists())
          face_edges_[at.face()][static_cast<std::size_t>(at.side())] =
              static_cast<EdgeId>(edges_.size());
      edges_.push_back({ends.first, ends.second, side, other});
    }

    // The corner whose next corner is the smallest neighbour, or whose spoke to it is a border.
    for (const auto& [ends, side] : half_edges) {
      const bool is_border = !half_edges.contains({ends.second, ends.first});
      FaceSide& first = corners_[ends.first];
      if (is_border || !first.exists()) first = FaceSide(side.face(), (side.side() + 1) % 3);
    }
  }

  Topology view() const { return {faces_, face_edges_, edges_, corners_, border_edges_}; }

 private:
  VertexId corner(FaceId face, int index) const {
    return faces_[face][static_cast<std::size_t>(index % 3)];
  }

  std::vector<std::array<VertexId, 3>> faces_;
  std::vector<std::array<EdgeId, 3>> face_edges_;
  std::vector<Edge> edges_;
  std::vector<FaceSide> corners_;
  std::vector<EdgeId> border_edges_;
};

}  // namespace plait::test
