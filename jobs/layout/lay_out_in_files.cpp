#include "layout/lay_out_in_files.h"

#include <algorithm>
#include <array>
#include <utility>

#include "layout/file_layout.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// The place of a side in the order in which sides number edges, and the side.
constexpr std::array<std::uint32_t, 3> kTurnOfSide = {1, 2, 0};
static_assert(kSideOrder[1] == 0 && kSideOrder[2] == 1 && kSideOrder[0] == 2);
std::uint32_t turn_of(FaceSide side) {
  return 3 * side.face() + kTurnOfSide[static_cast<std::size_t>(side.side())];
}
FaceSide side_at(std::uint32_t turn) {
  return turn == kNoId ? FaceSide() : FaceSide(turn / 3, kSideOrder[turn % 3]);
}

}  // namespace

FileLayoutResult FileLayout::run() {
  read_mesh();
  match_sides();
  give_keys();
  order_faces();
  pair_sides();
  number_edges();
  write_face_edges();
  write_vertex_corners();
  find_first_corners();
  write_codes();
  write_positions();
  meter_.enter("compressing the mesh");
  std::uint64_t before = 0;
  result_.base_mesh = packed_->finish(
      [&](std::uint64_t bytes) { meter_.add((bytes - std::exchange(before, bytes)) / 16); });
  packed_.reset();
  index_->finish(result_.base_mesh.checksum);
  return std::move(result_);
}

void FileLayout::pair_sides() {
  meter_.enter("pairing sides");
  sides_->sort();
  make(edges_, 2);
  Pair next = 0;
  bool more = sides_->next(next);
  while (more) {
    const Pair first = next;
    FaceSide beyond;
    more = sides_->next(next);
    meter_.add();
    if (more && first_of(next) == first_of(first)) {
      beyond = from_code(second_of(next));
      more = sides_->next(next);
      meter_.add();
    }
    edges_->push(
        pair_of(turn_of(from_code(second_of(first))), beyond.exists() ? turn_of(beyond) : kNoId));
  }
  end(sides_);
}

void FileLayout::number_edges() {
  meter_.enter("numbering edges");
  edges_->sort();
  make(edges_of_sides_, 2);
  SequentialReader<FaceVertices> faces = index_->read<FaceVertices>(MeshArray::kFaces);
  FaceVertices vertices{};
  std::uint64_t faces_read = 0;
  Pair turns = 0;
  for (EdgeId edge = 0; edges_->next(turns); ++edge) {
    const FaceSide here = side_at(first_of(turns)), beyond = side_at(second_of(turns));
    for (; faces_read <= here.face(); ++faces_read) faces.next(vertices);
    const Edge made =
        edge_of(vertices[static_cast<std::size_t>((here.side() + 1) % 3)],
                vertices[static_cast<std::size_t>((here.side() + 2) % 3)], here, beyond);
    index_->put(MeshArray::kEdges, made);
    if (made.is_border()) index_->put(MeshArray::kBorderEdges, edge);
    edges_of_sides_->push(pair_of(first_of(turns), edge));
    if (beyond.exists()) edges_of_sides_->push(pair_of(second_of(turns), edge));
    meter_.add();
  }
  end(edges_);
}

void FileLayout::write_face_edges() {
  meter_.enter("edges of faces");
  edges_of_sides_->sort();
  std::array<EdgeId, 3> edges{};
  Pair next = 0;
  while (edges_of_sides_->next(next)) {
    const std::uint32_t turn = first_of(next);
    edges[static_cast<std::size_t>(kSideOrder[turn % 3])] = second_of(next);
    if (turn % 3 == 2) index_->put(MeshArray::kFaceEdges, edges);
    meter_.add();
  }
  end(edges_of_sides_);
}

void FileLayout::write_vertex_corners() {
  meter_.enter("corners of vertices");
  Pair next = 0;
  while (vertex_firsts_->next(next)) {
    index_->put(MeshArray::kVertexCorners, second_of(next));
    meter_.add();
  }
  end(vertex_firsts_);
}

void FileLayout::find_first_corners() {
  meter_.enter("first corners");
  make(first_namings_, 3);
  new_vertices_.emplace(3 * result_.counts.faces);
  first_corners_.emplace(in_);
  Pair next = 0;
  VertexId vertex = kNoId;
  std::uint32_t first = 0;
  while (namings_->next(next)) {
    if (first_of(next) != vertex) {
      vertex = first_of(next);
      first = second_of(next);
      new_vertices_->set(first);
      first_corners_->put(first);
    }
    first_namings_->push(pair_of(second_of(next), first));
    meter_.add();
  }
  new_vertices_->rank();
  end(namings_);
}

void FileLayout::write_codes() {
  meter_.enter("codes of corners");
  first_namings_->sort();
  CornerCodes codes;
  SequentialReader<FaceVertices> faces = index_->read<FaceVertices>(MeshArray::kFaces);
  FaceVertices vertices{};
  Pair next = 0;
  for (std::uint64_t corner = 0; first_namings_->next(next); ++corner) {
    if (corner % 3 == 0) faces.next(vertices);
    if (first_of(next) == second_of(next)) packed_->put_number(vertices[corner % 3]);
    packed_->put_corner(codes.code(new_vertices_->before(second_of(next))));
    meter_.add();
  }
  end(first_namings_);
}

void FileLayout::write_positions() {
  meter_.enter("positions");
  const bool has_map = result_.counts.vertices != result_.input_vertex_count;
  SequentialReader<Vector3<double>> positions = positions_->read();
  SequentialReader<VertexId> numbers = input_vertices_->read();
  SequentialReader<std::uint32_t> first_corners = first_corners_->read();
  make(placed_, 3);
  Vector3<double> position;
  VertexId number = 0;
  std::uint32_t first = 0;
  while (positions.next(position) && numbers.next(number) && first_corners.next(first)) {
    index_->put(MeshArray::kPositions, position);
    placed_->push({new_vertices_->before(first), {position.x, position.y, position.z}});
    packed_->put_input_vertex(number);
    if (has_map) index_->put(MeshArray::kInputVertices, number);
    meter_.add();
  }
  positions_.reset();
  input_vertices_.reset();
  first_corners_.reset();
  new_vertices_.reset();
  placed_->sort();
  PlacedPosition placed{};
  while (placed_->next(placed)) {
    packed_->put_position({placed.position[0], placed.position[1], placed.position[2]});
    meter_.add();
  }
  end(placed_);
}

FileLayoutResult lay_out_in_files(const FileLayoutRequest& request, const Directory& directory) {
  return FileLayout(request, directory).run();
}

std::uint64_t disk_need(std::uint64_t vertices, std::uint64_t faces, SortMemory memory) {
  const std::uint64_t corners = 3 * faces, edges = corners / 2;
  const std::uint64_t kept = (sizeof(Vector3<double>) + 2 * sizeof(VertexId)) * vertices;
  const std::uint64_t at_vertices = sizeof(CornerAtVertex) * corners;
  const std::uint64_t of_faces = sizeof(CornerOfFace) * corners;
  const std::uint64_t keyed = sizeof(KeyedFace) * faces;
  const std::uint64_t made =
      BaseIndexLayout({vertices, edges, faces, 0}, {true, true}).file_bytes() +
      packed_mesh_bytes(vertices, faces, {}) + packed_maps_bytes(vertices, faces);
  const std::uint64_t pairs = sizeof(Pair) * corners;
  std::uint64_t need = std::max(
      {sizeof(Vector3<double>) * vertices + at_vertices + of_faces + kept, of_faces + keyed + kept,
       keyed + 2 * pairs + sizeof(Pair) * vertices + made + kept, 3 * pairs + made + kept});
  // A sort that merges twice has its records twice.
  const std::uint64_t run = memory.bytes / 8 * 5;
  if (run > 0 && memory.read_bytes > 0 && of_faces / run > run / memory.read_bytes)
    need += of_faces;
  return need + packed_mesh_bytes(vertices, faces, {}) / 2;  // base.mesh, of which this is a guess
}

PLAIT_END_NAMESPACE
