#include "mesh/mesh_piece.h"

#include <algorithm>
#include <bit>
#include <span>
#include <utility>

#include "mesh/mesh_region.h"
#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// Of an ordinary mesh, which has half as many vertices as faces: the arrays of a piece, the pages
/// from which they are read, and the lists of find_region() and of an executor.
constexpr std::uint64_t kBytesOfFace = 260;
/// Of a face that is only around others, so that a vertex of many faces is refused in time.
constexpr std::uint64_t kLeastBytesOfFace = 90;
/// Vertices whose positions are in memory at once while they are copied.
constexpr VertexId kVerticesAtOnce = 1 << 15;

/// The places of numbers in a list of different ones.
class NumberPlaces {
 public:
  explicit NumberPlaces(std::span<const std::uint32_t> numbers)
      : shift_(32 - std::max(1, static_cast<int>(std::bit_width(2 * numbers.size())))),
        table_(std::size_t{1} << (32 - shift_)),
        numbers_(numbers) {
    for (std::uint32_t at = 0; at < numbers.size(); ++at) {
      std::size_t slot = hash(numbers[at]);
      while (table_[slot] != 0) slot = (slot + 1) % table_.size();
      table_[slot] = at + 1;
    }
  }
  /// kNoId: it is not there.
  std::uint32_t of(std::uint32_t number) const {
    for (std::size_t slot = hash(number); table_[slot] != 0; slot = (slot + 1) % table_.size())
      if (numbers_[table_[slot] - 1] == number) return table_[slot] - 1;
    return kNoId;
  }

 private:
  std::size_t hash(std::uint32_t number) const { return number * 0x9e3779b1u >> shift_; }

  int shift_;
  std::vector<std::uint32_t> table_;  ///< one more than the place; 0: free
  std::span<const std::uint32_t> numbers_;
};

class PieceReader {
 public:
  PieceReader(const BaseMesh& mesh, EdgeId first, EdgeId after, MeshRegion region)
      : mesh_(mesh.arrays().mesh),
        region_(std::move(region)),
        faces_(merged(region_.faces, region_.faces_around)),
        face_places_(faces_),
        vertex_places_(region_.neighbours) {
    piece_.first = first;
    piece_.after = after;
  }

  MeshPiece read() {
    number_edges();
    for (const FaceId face : faces_) {
      std::array<VertexId, 3>& corners = piece_.faces.emplace_back();
      for (std::size_t side = 0; side < 3; ++side)
        corners[side] = vertex_places_.of(mesh_.faces[face][side]);
    }
    piece_.vertex_corners.resize(region_.neighbours.size());
    for (const VertexId vertex : region_.vertices) {
      const VertexId number = vertex_places_.of(vertex);
      piece_.walkable.push_back(number);
      piece_.vertex_corners[number] = moved(mesh_.vertex_corners[vertex]);
      if (is_own(piece_.vertex_corners[number].face())) piece_.own.push_back(number);
    }
    return std::move(piece_);
  }

  std::vector<VertexId> release_vertices() { return std::move(region_.neighbours); }

 private:
  static std::vector<FaceId> merged(const std::vector<FaceId>& a, const std::vector<FaceId>& b) {
    std::vector<FaceId> all(a.size() + b.size());
    std::ranges::merge(a, b, all.begin());
    return all;
  }

  FaceSide moved(FaceSide side) const {
    if (!side.exists()) return {};
    const std::uint32_t face = face_places_.of(side.face());
    return face == kNoId ? FaceSide() : FaceSide(face, side.side());
  }

  void number_edges() {
    const EdgeId first = piece_.first, after = piece_.after;
    std::vector<EdgeId> others;
    for (const FaceId face : faces_)
      for (const EdgeId edge : mesh_.face_edges[face])
        if (edge < first || edge >= after) others.push_back(edge);
    std::ranges::sort(others);
    others.erase(std::unique(others.begin(), others.end()), others.end());
    const auto behind = std::ranges::lower_bound(others, first);
    piece_.edges_before = static_cast<EdgeId>(behind - others.begin());
    piece_.edges.reserve(others.size() + (after - first));
    for (auto edge = others.begin(); edge != behind; ++edge) add_edge(*edge);
    for (EdgeId edge = first; edge < after; ++edge) add_edge(edge);
    for (auto edge = behind; edge != others.end(); ++edge) add_edge(*edge);
    const NumberPlaces places(others);
    piece_.faces.reserve(faces_.size());
    piece_.face_edges.reserve(faces_.size());
    for (const FaceId face : faces_) {
      std::array<EdgeId, 3>& edges = piece_.face_edges.emplace_back();
      for (std::size_t side = 0; side < 3; ++side) {
        const EdgeId edge = mesh_.face_edges[face][side];
        if (edge >= first && edge < after)
          edges[side] = piece_.edges_before + (edge - first);
        else
          edges[side] = places.of(edge) + (edge < first ? 0 : after - first);
      }
    }
  }

  void add_edge(EdgeId number) {
    const Edge& edge = mesh_.edges[number];
    if (edge.is_border()) piece_.border_edges.push_back(static_cast<EdgeId>(piece_.edges.size()));
    piece_.edges.push_back({vertex_places_.of(edge.start), vertex_places_.of(edge.end),
                            moved(edge.own), moved(edge.other)});
  }

  /// Whether the lowest edge of the face is one of the range.
  bool is_own(FaceId face) const {
    const EdgeId lowest = *std::ranges::min_element(piece_.face_edges[face]);
    return lowest >= piece_.edges_before && lowest < piece_.edges_after();
  }

  const Topology& mesh_;
  MeshRegion region_;
  std::vector<FaceId> faces_;  ///< [face of the piece]
  NumberPlaces face_places_, vertex_places_;
  MeshPiece piece_;
};

void forget_all(const BaseMesh& mesh) {
  const MeshPages& pages = *mesh.pages();
  pages.forget(MeshArray::kPositions, 0, mesh.vertex_count());
  pages.forget(MeshArray::kFaces, 0, mesh.face_count());
  pages.forget(MeshArray::kFaceEdges, 0, mesh.face_count());
  pages.forget(MeshArray::kEdges, 0, mesh.edge_count());
  pages.forget(MeshArray::kVertexCorners, 0, mesh.vertex_count());
}

/// Positions are in the order of the input, so those of a piece may be anywhere.
void read_positions(const BaseMesh& mesh, MeshPiece& piece) {
  const MeshPages& pages = *mesh.pages();
  const std::span<const VertexId> vertices = piece.vertices;
  piece.positions.reserve(vertices.size());
  for (std::size_t at = 0; at < vertices.size();) {
    std::size_t end = at;
    while (end < vertices.size() && vertices[end] - vertices[at] < kVerticesAtOnce) ++end;
    const std::span<const VertexId> run = vertices.subspan(at, end - at);
    pages.need_elements(MeshArray::kPositions, run);
    for (const VertexId vertex : run) piece.positions.push_back(mesh.arrays().positions[vertex]);
    pages.forget(MeshArray::kPositions, run.front(), std::uint64_t{run.back()} + 1);
    at = end;
  }
}

/// For an ordinary mesh: about 6 sqrt(n) of n edges are at the cut.
EdgeId edges_of_piece(std::uint64_t bytes, std::uint64_t bytes_of_vertex,
                      std::uint64_t bytes_of_half) {
  const std::uint64_t bytes_of_two_faces = 2 * kBytesOfFace + bytes_of_vertex;
  const double root = static_cast<double>(bytes) / 12 /
                      static_cast<double>(std::max<std::uint64_t>(1, bytes_of_half));
  const auto at_cut = static_cast<std::uint64_t>(std::min(root * root, 4e9));
  return static_cast<EdgeId>(std::clamp<std::uint64_t>(
      std::min(3 * (bytes / 2 / bytes_of_two_faces), at_cut), 1, kNoId - 1));
}

}  // namespace

MeshPiece take_piece(const BaseMesh& mesh, EdgeId first, EdgeId after) try {
  PieceReader reader(mesh, first, after,
                     find_region(mesh.arrays(), mesh.pages(), first, after,
                                 mesh.piece_bytes() / kLeastBytesOfFace));
  MeshPiece piece = reader.read();
  forget_all(mesh);
  piece.vertices = reader.release_vertices();
  read_positions(mesh, piece);
  return piece;
} catch (...) {
  forget_all(mesh);
  throw;
}

MeshPiece take_last_piece(const BaseMesh& mesh, EdgeId after, std::uint64_t bytes_of_vertex,
                          std::uint64_t bytes_of_half) {
  EdgeId count =
      std::min(after, edges_of_piece(mesh.piece_bytes(), bytes_of_vertex, bytes_of_half));
  for (;; count /= 2) try {
      return take_piece(mesh, after - count, after);
    } catch (const Error& error) {
      if (error.code() != ErrorCode::kBudget || count == 1) throw;
    }
}

PLAIT_END_NAMESPACE
