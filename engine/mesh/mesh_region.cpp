#include "mesh/mesh_region.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <span>

#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

using Numbers = std::vector<std::uint32_t>;

void sort_out(Numbers& numbers) {
  std::ranges::sort(numbers);
  numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
}

/// Collects a region; reads before each look at the arrays what the look needs.
class Search {
 public:
  Search(const MeshArrays& arrays, const MeshPages* pages, std::uint64_t most_faces)
      : mesh_(arrays.mesh), pages_(pages), most_faces_(most_faces) {}

  MeshRegion run(EdgeId first, EdgeId after) {
    MeshRegion region;
    find_faces(first, after);
    region.faces = all_faces();
    read_faces(region.faces);
    for (EdgeId edge = first; pages_ != nullptr && edge < after; ++edge) check_edge(edge);
    Numbers beyond;  // edges out of the range, once for each face of the region that has them
    for (const FaceId face : region.faces)
      for (const EdgeId edge : mesh_.face_edges[face])
        if (edge < first || edge >= after) beyond.push_back(edge);
    std::ranges::sort(beyond);
    const Numbers rim = ends_of_rim(beyond);
    beyond.erase(std::unique(beyond.begin(), beyond.end()), beyond.end());
    read_edges(beyond);
    region.vertices = vertices_of(region.faces, rim);
    region.neighbours = region.vertices;
    region.faces_around = walk_around(rim, region.faces.size());
    for (const FaceId face : region.faces_around)
      region.neighbours.insert(region.neighbours.end(), mesh_.faces[face].begin(),
                               mesh_.faces[face].end());
    sort_out(region.neighbours);
    return region;
  }

 private:
  void need(MeshArray array, std::span<const std::uint32_t> elements) const {
    if (pages_ != nullptr) pages_->need_elements(array, elements);
  }

  std::array<FaceSide, 2> sides_of(EdgeId edge) const {
    return {mesh_.edges[edge].own, mesh_.edges[edge].other};
  }

  /// Finds the faces of the region. Faces are numbered with the edges that they use first, so most
  /// of them follow each other: these are found without a sort.
  void find_faces(EdgeId first, EdgeId after) {
    if (pages_ != nullptr) pages_->need_range(MeshArray::kEdges, first, after);
    const auto first_face = [&](EdgeId edge) {
      const auto [own, other] = sides_of(edge);
      return other.exists() ? std::min(own.face(), other.face()) : own.face();
    };
    lowest_ = first_face(first);
    is_listed_.resize(std::max(lowest_, first_face(after - 1)) + 1 - lowest_);
    for (EdgeId edge = first; edge < after; ++edge)
      for (const FaceSide side : sides_of(edge)) {
        if (!side.exists()) continue;
        const FaceId at = side.face() - lowest_;  // of a lower face: beyond the list
        if (at < is_listed_.size())
          is_listed_[at] = true;
        else
          elsewhere_.push_back(side.face());
      }
    sort_out(elsewhere_);
  }

  Numbers all_faces() const {
    const auto below = std::ranges::lower_bound(elsewhere_, lowest_);
    Numbers faces(elsewhere_.begin(), below);
    for (FaceId at = 0; at < is_listed_.size(); ++at)
      if (is_listed_[at]) faces.push_back(lowest_ + at);
    faces.insert(faces.end(), below, elsewhere_.end());
    return faces;
  }

  bool is_in_region(FaceId face) const {
    const FaceId at = face - lowest_;
    return at < is_listed_.size() ? is_listed_[at] : std::ranges::binary_search(elsewhere_, face);
  }

  /// The faces, and that their sides are sides of their edges. So a step across a side leads to
  /// another side of the same edge.
  void read_faces(const Numbers& faces) const {
    need(MeshArray::kFaces, faces);
    need(MeshArray::kFaceEdges, faces);
    if (pages_ == nullptr) return;
    for (const FaceId face : faces) need(MeshArray::kEdges, mesh_.face_edges[face]);
    pages_->check_sides(faces);
  }

  void check_edge(EdgeId edge) const {
    if (mesh_.edges[edge].is_border() != std::ranges::binary_search(mesh_.border_edges, edge))
      pages_->refuse(MeshArray::kEdges, edge,
                     fmt::format("edge {}: the list of border edges says another thing", edge));
    for (const FaceSide side : sides_of(edge))
      if (side.exists() &&
          mesh_.face_edges[side.face()][static_cast<std::size_t>(side.side())] != edge)
        pages_->refuse(MeshArray::kEdges, edge,
                       fmt::format("edge {} names side {} of face {}, which has another edge", edge,
                                   side.side(), side.face()));
  }

  /// Edges that read_faces() has read, with both of their faces.
  void read_edges(const Numbers& edges) const {
    if (pages_ == nullptr) return;
    Numbers faces;
    for (const EdgeId edge : edges)
      for (const FaceSide side : sides_of(edge))
        if (side.exists()) faces.push_back(side.face());
    sort_out(faces);
    read_faces(faces);
    for (const EdgeId edge : edges) check_edge(edge);
  }

  /// The ends of the edges that stand once in `sorted`, and have a face that is not in the region.
  /// Around all other vertices of the region there are faces of the region alone.
  Numbers ends_of_rim(const Numbers& sorted) const {
    Numbers ends;
    for (std::size_t at = 0; at < sorted.size(); ++at) {
      if (at + 1 < sorted.size() && sorted[at + 1] == sorted[at]) {
        ++at;
        continue;
      }
      const Edge& edge = mesh_.edges[sorted[at]];
      if (!edge.is_border()) ends.insert(ends.end(), {edge.start, edge.end});
    }
    sort_out(ends);
    return ends;
  }

  void check_corner(VertexId vertex, FaceSide corner) const {
    if (pages_ != nullptr &&
        mesh_.faces[corner.face()][static_cast<std::size_t>(corner.side())] != vertex)
      pages_->refuse(MeshArray::kVertexCorners, vertex,
                     fmt::format("vertex {} is not at its corner", vertex));
  }

  /// A vertex is found at the face of its first corner, or on the rim.
  Numbers vertices_of(const Numbers& faces, const Numbers& rim) const {
    Numbers vertices = rim;
    need(MeshArray::kVertexCorners, rim);
    for (const FaceId face : faces) {
      const std::array<VertexId, 3>& corners = mesh_.faces[face];
      need(MeshArray::kVertexCorners, corners);
      for (int number = 0; number < 3; ++number) {
        const VertexId vertex = corners[static_cast<std::size_t>(number)];
        const FaceSide corner = mesh_.vertex_corners[vertex];
        if (corner == FaceSide(face, number))
          vertices.push_back(vertex);
        else if (is_in_region(corner.face()))
          check_corner(vertex, corner);
        else if (pages_ != nullptr && !std::ranges::binary_search(rim, vertex))
          pages_->refuse(MeshArray::kVertexCorners, vertex,
                         fmt::format("vertex {} has its corner at another place", vertex));
      }
    }
    sort_out(vertices);
    return vertices;
  }

  /// Walks around all the vertices at once, a face at a time, and returns the faces out of the
  /// region that the walks come through. Steps go back and forth over each side that was read, so
  /// each walk comes back to its first corner or to a border.
  Numbers walk_around(const Numbers& vertices, std::uint64_t in_region) const {
    struct Walk {
      FaceSide first, at;
    };
    std::vector<Walk> walks;
    Numbers faces, around;
    std::size_t sorted_out = 0;
    for (const VertexId vertex : vertices) {
      walks.push_back({mesh_.vertex_corners[vertex], mesh_.vertex_corners[vertex]});
      faces.push_back(walks.back().at.face());
    }
    sort_out(faces);
    read_faces(faces);
    for (std::size_t at = 0; at < walks.size(); ++at) check_corner(vertices[at], walks[at].first);
    while (!walks.empty()) {
      Numbers crossed;
      for (const Walk& walk : walks) {
        if (!is_in_region(walk.at.face())) around.push_back(walk.at.face());
        crossed.push_back(
            mesh_.face_edges[walk.at.face()][static_cast<std::size_t>((walk.at.side() + 1) % 3)]);
      }
      if (around.size() > 2 * sorted_out + 1024) {  // a face is met at each of its corners
        sort_out(around);
        sorted_out = around.size();
        check_count(in_region + sorted_out);
      }
      sort_out(crossed);
      read_edges(crossed);
      std::erase_if(walks, [&](Walk& walk) {
        walk.at = mesh_.next_corner(walk.at);
        return !walk.at.exists() || walk.at == walk.first;
      });
    }
    sort_out(around);
    check_count(in_region + around.size());
    return around;
  }

  void check_count(std::uint64_t faces) const {
    if (faces > most_faces_)
      throw Error(ErrorCode::kBudget,
                  fmt::format("take a piece of a base mesh: its vertices have more than {} faces "
                              "around them, for which there is memory",
                              most_faces_));
  }

  const Topology& mesh_;
  const MeshPages* pages_;
  std::uint64_t most_faces_;
  FaceId lowest_ = 0;            ///< of the faces that is_listed_ is about
  std::vector<bool> is_listed_;  ///< [face - lowest_] whether it is in the region
  Numbers elsewhere_;            ///< the other faces of the region, ascending
};

}  // namespace

MeshRegion find_region(const MeshArrays& arrays, const MeshPages* pages, EdgeId first, EdgeId after,
                       std::uint64_t most_faces) {
  return Search(arrays, pages, most_faces).run(first, after);
}

PLAIT_END_NAMESPACE
