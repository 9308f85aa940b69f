// The first passes of a layout in files: they read the mesh, check it as BaseMesh::build() does,
// and put its faces in the order of the Hilbert curve.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>
#include <utility>
#include <vector>

#include "base/text.h"
#include "layout/file_layout.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

void FileLayout::begin(std::uint64_t vertices, std::uint64_t faces) {
  if (request_.begin) request_.begin(vertices, faces);
  if (const std::uint64_t bits = RankedBits::bytes_for(3 * faces), most = share(3).bytes;
      bits > most)
    throw Error(ErrorCode::kBudget,
                fmt::format("lay out {}: {} faces need {} for one bit of each corner, and {} are "
                            "left for it: take --memory larger",
                            request_.mesh.native(), faces, format_bytes(bits), format_bytes(most)));
  // One for each record of each pass; of the compression one for 16 bytes.
  meter_.set_total(5 * vertices + 23 * faces + (32 * vertices + 16 * faces) / 16);
  meter_.enter("reading the mesh");
  input_positions_.emplace(in_);
  make(at_vertices_, 3);
}

void FileLayout::take(const IndexedMesh& part) {
  for (const Vector3<double>& position : part.positions) input_positions_->put(position);
  for (const FaceVertices& face : part.faces) {
    const auto number = static_cast<FaceId>(face_count_++);
    if (face[0] == face[1] || face[1] == face[2] || face[2] == face[0]) {
      // Told at the end: what the file says is checked before.
      if (!face_with_repeated_) {
        face_with_repeated_ = number;
        repeated_ = face;
      }
      continue;
    }
    for (int corner = 0; corner < 3; ++corner)
      at_vertices_->push({face[static_cast<std::size_t>(corner)], FaceSide(number, corner).code,
                          face[static_cast<std::size_t>((corner + 1) % 3)],
                          face[static_cast<std::size_t>((corner + 2) % 3)]});
  }
  meter_.add(part.positions.size() + part.faces.size());
}

void FileLayout::read_mesh() {
  stream_mesh(request_.mesh, *this, &result_.warnings);
  const std::string& source = request_.mesh.native();
  if (face_count_ == 0)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("{}: expected at least one face, found none", source));
  if (face_with_repeated_) throw repeated_corner(source, *face_with_repeated_, repeated_);
  result_.input_vertex_count = input_positions_->count();
  result_.counts.faces = face_count_;
}

void FileLayout::match_sides() {
  meter_.enter("matching sides");
  at_vertices_->sort();
  make(of_faces_, 5);
  positions_.emplace(in_);
  input_vertices_.emplace(in_);
  VertexFan fan(request_.mesh.native());
  std::vector<CornerAtVertex> corners;
  CornerAtVertex next;
  bool more = at_vertices_->next(next);
  SequentialReader<Vector3<double>> positions = input_positions_->read();
  const std::uint64_t most =
      std::max<std::uint64_t>(1u << 16, request_.memory.bytes / 8 / sizeof(CornerAtVertex));
  Vector3<double> position;
  for (VertexId vertex = 0; positions.next(position); ++vertex) {
    corners.clear();
    for (; more && next.vertex == vertex; more = at_vertices_->next(next)) {
      if (corners.size() == most)
        throw Error(ErrorCode::kBudget,
                    fmt::format("{}: vertex {}: its faces, more than {}, do not fit into the "
                                "memory: take --memory larger",
                                request_.mesh.native(), vertex, most));
      corners.push_back(next);
    }
    meter_.add(1 + corners.size());
    if (corners.empty()) continue;  // no face uses it
    fan.find(corners);
    const auto kept = static_cast<VertexId>(positions_->count());
    positions_->put(position);
    words_.add(position);
    input_vertices_->put(vertex);
    box_.add(position);
    for (std::size_t at = 0; at < corners.size(); ++at)
      of_faces_->push({corners[at].code,
                       kept,
                       fan.twins()[at],
                       at == fan.first_corner() ? 1u : 0u,
                       {position.x, position.y, position.z}});
  }
  fan.check_all();
  input_positions_.reset();
  end(at_vertices_);
  BaseCounts& counts = result_.counts;
  counts.vertices = positions_->count();
  counts.border_edges = fan.border_edges();
  counts.edges = (3 * counts.faces + counts.border_edges) / 2;
  if (counts.vertices != result_.input_vertex_count)
    result_.warnings.push_back(dropped_vertices_text(request_.mesh.native(),
                                                     result_.input_vertex_count - counts.vertices,
                                                     result_.input_vertex_count));
}

void FileLayout::give_keys() {
  meter_.enter("finding places on the curve");
  of_faces_->sort();
  make(keyed_faces_, 3);
  const HilbertCells cells(box_);
  std::uint64_t before = 0;
  std::array<CornerOfFace, 3> corners;
  while (of_faces_->next(corners[0]) && of_faces_->next(corners[1]) &&
         of_faces_->next(corners[2])) {
    KeyedFace face{};
    std::array<Vector3<double>, 3> p;
    for (std::size_t i = 0; i < 3; ++i) {
      const CornerOfFace& corner = corners[i];
      p[i] = {corner.position[0], corner.position[1], corner.position[2]};
      face.vertices[i] = corner.vertex;
      face.twins[(i + 2) % 3] = corner.twin;
      face.firsts |= corner.is_first << i;
    }
    face.number = from_code(corners[0].code).face();
    face.key = cells.key(p[0], p[1], p[2]);
    keeps_order_ = keeps_order_ && std::exchange(before, face.key) <= face.key;
    keyed_faces_->push(face);
    meter_.add(3);
  }
  end(of_faces_);
}

void FileLayout::order_faces() {
  meter_.enter("ordering faces");
  keyed_faces_->sort();
  const BaseCounts& counts = result_.counts;
  index_.emplace(in_, counts,
                 IndexMaps{counts.vertices != result_.input_vertex_count, !keeps_order_},
                 result_.input_vertex_count);
  packed_.emplace(in_, counts.vertices, counts.faces, result_.input_vertex_count, words_.words());
  make(sides_, 2);
  make(namings_, 2);
  make(vertex_firsts_, 1);
  KeyedFace old;
  for (FaceId face = 0; keyed_faces_->next(old); ++face) {
    index_->put(MeshArray::kFaces, old.vertices);
    if (!keeps_order_) index_->put(MeshArray::kInputFaces, 2 * old.number);
    packed_->put_input_face(2 * old.number);
    for (int i = 0; i < 3; ++i) {
      const FaceSide here(face, i);  // a side and a corner
      const VertexId vertex = old.vertices[static_cast<std::size_t>(i)];
      // An edge has the name of the lower one of its sides in the input.
      const std::uint32_t name =
          std::min(FaceSide(old.number, i).code, old.twins[static_cast<std::size_t>(i)]);
      sides_->push(pair_of(name, here.code));
      namings_->push(pair_of(vertex, here.code));
      if ((old.firsts >> i & 1) != 0) vertex_firsts_->push(pair_of(vertex, here.code));
    }
    meter_.add(3);
  }
  end(keyed_faces_);
  // What waits takes no more memory than it must.
  namings_->sort();
  vertex_firsts_->sort();
}

PLAIT_END_NAMESPACE
