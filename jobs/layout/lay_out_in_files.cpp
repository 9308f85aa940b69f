#include "layout/lay_out_in_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "base/text.h"
#include "layout/hilbert_cells.h"
#include "layout/index_writer.h"
#include "layout/packed_writer.h"
#include "layout/ranked_bits.h"
#include "layout/temporary_file.h"
#include "layout/vertex_fan.h"
#include "mesh/connectivity.h"
#include "mesh/files/mesh_stream.h"
#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

using Position = Vector3<double>;

/// A corner of a face, with what its vertex knows.
struct CornerOfFace {
  std::uint32_t code;  ///< FaceSide
  VertexId vertex;
  std::uint32_t twin;      ///< of the side to the next corner
  std::uint32_t is_first;  ///< in the fan of its vertex
  std::array<double, 3> position;
  friend bool operator<(const CornerOfFace& a, const CornerOfFace& b) { return a.code < b.code; }
};

/// A face with what the order of the faces needs.
struct KeyedFace {
  std::uint64_t key;  ///< on the Hilbert curve
  FaceId number;      ///< in the input
  FaceVertices vertices;
  SideCodes twins;       ///< [side], of the input
  std::uint32_t firsts;  ///< one bit for each corner that is the first of its fan
  friend bool operator<(const KeyedFace& a, const KeyedFace& b) {
    return a.key != b.key ? a.key < b.key : a.number < b.number;
  }
};

/// A position, and the place of its vertex in the order in which corners name vertices.
struct PlacedPosition {
  std::uint64_t place;
  std::array<double, 3> position;
  friend bool operator<(const PlacedPosition& a, const PlacedPosition& b) {
    return a.place < b.place;
  }
};

/// Two numbers of 32 bits that are sorted by the first, then by the second.
using Pair = std::uint64_t;
constexpr Pair pair_of(std::uint32_t first, std::uint32_t second) {
  return Pair{first} << 32 | second;
}
constexpr std::uint32_t first_of(Pair pair) { return static_cast<std::uint32_t>(pair >> 32); }
constexpr std::uint32_t second_of(Pair pair) { return static_cast<std::uint32_t>(pair); }

/// The place of a side in the order in which sides number edges, and the side.
constexpr std::array<std::uint32_t, 3> kTurnOfSide = {1, 2, 0};
static_assert(kSideOrder[1] == 0 && kSideOrder[2] == 1 && kSideOrder[0] == 2);
std::uint32_t turn_of(FaceSide side) {
  return 3 * side.face() + kTurnOfSide[static_cast<std::size_t>(side.side())];
}
FaceSide side_at(std::uint32_t turn) {
  return turn == kNoId ? FaceSide() : FaceSide(turn / 3, kSideOrder[turn % 3]);
}

/// Counts the records that passes have handled, and lets the caller cancel.
class Meter {
 public:
  explicit Meter(const ProgressCallback& progress) : progress_(&progress) {}

  void set_total(std::uint64_t total) { total_ = total; }
  void enter(std::string_view phase) {
    phase_ = phase;
    tell();
  }
  void add(std::uint64_t records = 1) {
    done_ += records;
    if (done_ < next_) return;
    next_ = done_ + kEvery;
    tell();
  }

 private:
  static constexpr std::uint64_t kEvery = std::uint64_t{1} << 16;

  void tell() const {
    if (*progress_ && !(*progress_)({phase_, std::min(done_, total_), total_}))
      throw Error(ErrorCode::kCancelled, fmt::format("layout: cancelled, {}", phase_));
  }

  const ProgressCallback* progress_;
  std::string_view phase_;
  std::uint64_t done_ = 0, next_ = kEvery, total_ = 0;
};

class FileLayout final : private MeshSink {
 public:
  FileLayout(const FileLayoutRequest& request, const Directory& directory)
      : request_(request), in_(directory), meter_(request.progress) {}

  FileLayoutResult run();

 private:
  void begin(std::uint64_t vertices, std::uint64_t faces) override;
  void take(const IndexedMesh& part) override;
  void read_mesh();
  void match_sides();
  void give_keys();
  void order_faces();
  void pair_sides();
  void number_edges();
  void write_face_edges();
  void write_vertex_corners();
  void find_first_corners();
  void write_codes();
  void write_positions();

  SortMemory share(std::uint64_t eighths) const {
    return {request_.memory.bytes / 8 * eighths, request_.memory.read_bytes};
  }
  template <class Record>
  void make(std::optional<ExternalSort<Record>>& sort, std::uint64_t eighths) {
    sort.emplace(in_, share(eighths));
  }
  /// After the last record was taken.
  template <class Record>
  void end(std::optional<ExternalSort<Record>>& sort) {
    result_.merged_runs += sort->merged_runs();
    sort.reset();
  }

  const FileLayoutRequest& request_;
  const Directory& in_;
  Meter meter_;
  FileLayoutResult result_;
  std::uint64_t face_count_ = 0;
  FaceVertices repeated_{};
  std::optional<FaceId> face_with_repeated_;
  GrowingBox box_;
  WordsOfPositions words_;
  bool keeps_order_ = true;

  std::optional<RecordFile<Position>> input_positions_, positions_;
  std::optional<RecordFile<VertexId>> input_vertices_;
  std::optional<ExternalSort<CornerAtVertex>> at_vertices_;
  std::optional<ExternalSort<CornerOfFace>> of_faces_;
  std::optional<ExternalSort<KeyedFace>> keyed_faces_;
  std::optional<ExternalSort<Pair>> sides_;           ///< name of the edge, side
  std::optional<ExternalSort<Pair>> vertex_firsts_;   ///< vertex, its first corner
  std::optional<ExternalSort<Pair>> namings_;         ///< vertex, corner
  std::optional<ExternalSort<Pair>> edges_;           ///< turn of the first side, of the other one
  std::optional<ExternalSort<Pair>> edges_of_sides_;  ///< turn of the side, edge
  std::optional<ExternalSort<Pair>> first_namings_;   ///< corner, first corner of its vertex
  std::optional<RankedBits> new_vertices_;            ///< corners that name their vertex first
  std::optional<RecordFile<std::uint32_t>> first_corners_;  ///< [vertex]
  std::optional<ExternalSort<PlacedPosition>> placed_;
  std::optional<IndexWriter> index_;
  std::optional<PackedWriter> packed_;
};

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
  for (const Position& position : part.positions) input_positions_->put(position);
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
  SequentialReader<Position> positions = input_positions_->read();
  const std::uint64_t most =
      std::max<std::uint64_t>(1u << 16, request_.memory.bytes / 8 / sizeof(CornerAtVertex));
  Position position;
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
    std::array<Position, 3> p;
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
  SequentialReader<Position> positions = positions_->read();
  SequentialReader<VertexId> numbers = input_vertices_->read();
  SequentialReader<std::uint32_t> first_corners = first_corners_->read();
  make(placed_, 3);
  Position position;
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

}  // namespace

FileLayoutResult lay_out_in_files(const FileLayoutRequest& request, const Directory& directory) {
  return FileLayout(request, directory).run();
}

std::uint64_t disk_need(std::uint64_t vertices, std::uint64_t faces, SortMemory memory) {
  const std::uint64_t corners = 3 * faces, edges = corners / 2;
  const std::uint64_t kept = (sizeof(Position) + 2 * sizeof(VertexId)) * vertices;
  const std::uint64_t at_vertices = sizeof(CornerAtVertex) * corners;
  const std::uint64_t of_faces = sizeof(CornerOfFace) * corners;
  const std::uint64_t keyed = sizeof(KeyedFace) * faces;
  const std::uint64_t made =
      BaseIndexLayout({vertices, edges, faces, 0}, {true, true}).file_bytes() +
      packed_mesh_bytes(vertices, faces, {}) + packed_maps_bytes(vertices, faces);
  const std::uint64_t pairs = sizeof(Pair) * corners;
  std::uint64_t need = std::max(
      {sizeof(Position) * vertices + at_vertices + of_faces + kept, of_faces + keyed + kept,
       keyed + 2 * pairs + sizeof(Pair) * vertices + made + kept, 3 * pairs + made + kept});
  // A sort that merges twice has its records twice.
  const std::uint64_t run = memory.bytes / 8 * 5;
  if (run > 0 && memory.read_bytes > 0 && of_faces / run > run / memory.read_bytes)
    need += of_faces;
  return need + packed_mesh_bytes(vertices, faces, {}) / 2;  // base.mesh, of which this is a guess
}

PLAIT_END_NAMESPACE
