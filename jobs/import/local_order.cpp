#include "import/local_order.h"

#include <algorithm>
#include <array>
#include <bit>
#include <utility>

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// How far the loops look ahead, so that loads from memory overlap.
constexpr std::size_t kAhead = 16;
/// Faces are put in at most this number of heaps, by their smallest vertices: enough that the
/// vertices of a heap fit into a cache, and so few that the ends of all heaps do.
constexpr int kHeapBits = 13;

void counts_to_begins(std::vector<std::uint32_t>& counts) {
  std::uint32_t sum = 0;
  for (std::uint32_t& count : counts) count = std::exchange(sum, sum + count);
}

/// The bits of a number below 64, each followed by two zeros.
std::uint32_t spread_bits(std::uint32_t number) {
  number = (number | number << 8) & 0x0300f;
  number = (number | number << 4) & 0x030c3;
  return (number | number << 2) & 0x09249;
}

}  // namespace

void PlaceGrid::include(const Vector3<double>& point) {
  if (std::exchange(is_empty_, false)) low_ = high_ = point;
  low_ = {std::min(low_.x, point.x), std::min(low_.y, point.y), std::min(low_.z, point.z)};
  high_ = {std::max(high_.x, point.x), std::max(high_.y, point.y), std::max(high_.z, point.z)};
}

std::uint32_t PlaceGrid::cell(const Vector3<double>& point) const {
  // One size for all axes, so that cells are cubes. Halves keep the size finite.
  const double half =
      std::max({high_.x / 2 - low_.x / 2, high_.y / 2 - low_.y / 2, high_.z / 2 - low_.z / 2});
  const auto place = [&](double at, double low) {
    constexpr double kCellsOfAxis = 1 << kBitsOfAxis;
    const double part = half > 0 ? (at / 2 - low / 2) / half : 0;
    return spread_bits(static_cast<std::uint32_t>(std::min(part * kCellsOfAxis, kCellsOfAxis - 1)));
  };
  return place(point.x, low_.x) | place(point.y, low_.y) << 1 | place(point.z, low_.z) << 2;
}

LocalMesh local_mesh(std::span<FaceVertices> faces, HugeArray<std::uint32_t> cells) {
  LocalMesh mesh{HugeArray<FaceVertices>(faces.size()), HugeArray<VertexId>(cells.size()),
                 HugeArray<FaceId>(faces.size())};
  std::vector<std::uint32_t> end(PlaceGrid::kCells);
  for (const std::uint32_t cell : cells) ++end[cell];
  counts_to_begins(end);
  HugeArray<VertexId>& number = cells;  // the cell of a vertex becomes its new number
  for (VertexId vertex = 0; vertex < cells.size(); ++vertex) {
    number[vertex] = end[cells[vertex]]++;
    mesh.file_vertices[number[vertex]] = vertex;
  }

  const int shift = std::max(0, static_cast<int>(std::bit_width(cells.size())) - kHeapBits);
  const auto heap_of = [&](const FaceVertices& face) {
    return std::min(std::min(face[0], face[1]), face[2]) >> shift;
  };
  end.assign((cells.size() >> shift) + 1, 0);
  for (std::size_t face = 0; face < faces.size(); ++face) {
    if (face + kAhead < faces.size())
      for (const VertexId vertex : faces[face + kAhead]) __builtin_prefetch(&number[vertex]);
    for (VertexId& vertex : faces[face]) vertex = number[vertex];
    ++end[heap_of(faces[face])];
  }
  counts_to_begins(end);
  for (FaceId face = 0; face < faces.size(); ++face) {
    const std::uint32_t at = end[heap_of(faces[face])]++;
    mesh.faces[at] = faces[face];
    mesh.file_faces[at] = face;
  }
  return mesh;
}

std::vector<FaceVertices> faces_of_file(const LocalMesh& mesh) {
  std::vector<FaceVertices> faces = huge_vector<FaceVertices>(mesh.faces.size());
  for (FaceId face = 0; face < faces.size(); ++face)
    for (std::size_t corner = 0; corner < 3; ++corner)
      faces[mesh.file_faces[face]][corner] = mesh.file_vertices[mesh.faces[face][corner]];
  return faces;
}

PLAIT_END_NAMESPACE
