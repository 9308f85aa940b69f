// The file base.index: gives back what BaseMesh::build() computes, and nothing else, whatever
// somebody does to its bytes.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cstring>
#include <fstream>
#include <limits>
#include <optional>
#include <random>

#include "engine/store/sample_store.h"
#include "format/base_index_file.h"
#include "format/checksum.h"
#include "format/file_names.h"
#include "mesh/mesh_region.h"
#include "support/answering_operations.h"
#include "support/error_of.h"
#include "support/temporary_directory.h"
#include "support/test_meshes.h"

namespace plait::test {
namespace {

constexpr std::uint64_t kChecksum = 0x1234567890abcdef;

template <class Element>
bool same(std::span<const Element> a, std::span<const Element> b) {
  return a.size() == b.size() &&
         (a.empty() || std::memcmp(a.data(), b.data(), a.size_bytes()) == 0);
}

bool same_arrays(const BaseMesh& a, const BaseMesh& b) {
  const MeshArrays &left = a.all_arrays(), &right = b.all_arrays();
  return same(left.positions, right.positions) && same(left.mesh.faces, right.mesh.faces) &&
         same(left.mesh.face_edges, right.mesh.face_edges) &&
         same(left.mesh.edges, right.mesh.edges) &&
         same(left.mesh.vertex_corners, right.mesh.vertex_corners) &&
         same(left.mesh.border_edges, right.mesh.border_edges) &&
         same(left.input_vertices, right.input_vertices) &&
         same(left.input_faces, right.input_faces) &&
         left.input_vertex_count == right.input_vertex_count;
}

/// A mesh, and its file in a directory.
struct Indexed {
  explicit Indexed(IndexedMesh mesh)
      : base(BaseMesh::build(std::move(mesh))), directory(place.path()) {
    write_base_index_file(directory, kBaseIndexName, base, kChecksum, false);
    bytes = file_bytes(path());
  }
  std::filesystem::path path() const { return place.path() / kBaseIndexName; }
  ExpectedBase expected() const {
    return {{base.vertex_count(), base.edge_count(), base.face_count(), base.border_edge_count()},
            kChecksum};
  }
  BaseIndexLayout layout() const {
    return {expected().counts,
            {!base.arrays().input_vertices.empty(), !base.arrays().input_faces.empty()}};
  }
  std::optional<BaseMesh> open() const { return open_base_index_file(directory, expected()); }
  void check() const { check_base_index_file(directory, expected(), &base); }
  void write(std::span<const std::byte> content) const {
    std::ofstream(path(), std::ios::binary)
        .write(reinterpret_cast<const char*>(content.data()),
               static_cast<std::streamsize>(content.size()));
  }
  /// The file with another number in an array, and all checksums right again.
  template <class Number>
  std::vector<std::byte> forged(MeshArray array, std::size_t index, Number number) const {
    std::vector<std::byte> file = bytes;
    const BaseIndexLayout at = layout();
    const auto& place_of = at.place(array);
    std::memcpy(&file[place_of.offset + index * sizeof(Number)], &number, sizeof(Number));
    const std::uint64_t page = index * sizeof(Number) / kIndexPageBytes;
    const std::uint64_t first = page * kIndexPageBytes;
    const std::uint64_t sum = checksum_of(std::span(file).subspan(
        place_of.offset + first, std::min(kIndexPageBytes, place_of.bytes - first)));
    std::memcpy(&file[kIndexHeaderBytes + 8 * (place_of.first_page + page)], &sum, 8);
    const std::uint64_t of_head = checksum_of(std::span(file).first(at.head_bytes() - 8));
    std::memcpy(&file[at.head_bytes() - 8], &of_head, 8);
    return file;
  }

  BaseMesh base;
  TemporaryDirectory place{Medium::kMemory};
  Directory directory;
  std::vector<std::byte> bytes;
};

/// That what a part may read is as in the mesh that was built.
void check_region(const BaseMesh& right, const BaseMesh& part, EdgeId first, EdgeId after) {
  const MeshRegion& region = *part.region();
  const BaseMesh built = right.around(first, after);
  CHECK(region.faces == built.region()->faces);
  CHECK(region.vertices == built.region()->vertices);
  CHECK(region.neighbours == built.region()->neighbours);
  const Topology mesh = right.topology(), found = part.topology();
  const auto is_right = [&](FaceId face) {
    if (found.faces[face] != mesh.faces[face] || found.face_edges[face] != mesh.face_edges[face])
      return false;
    return std::ranges::all_of(mesh.face_edges[face], [&](EdgeId edge) {
      return std::memcmp(&found.edges[edge], &mesh.edges[edge], sizeof(Edge)) == 0;
    });
  };
  CHECK(std::ranges::all_of(region.faces, is_right));
  const auto walks_right = [&](VertexId vertex) {
    FaceSide corner = found.vertex_corners[vertex];
    if (corner != mesh.vertex_corners[vertex]) return false;
    do {
      if (!is_right(corner.face()) || found.next_corner(corner) != mesh.next_corner(corner))
        return false;
      corner = found.next_corner(corner);
    } while (corner.exists() && corner != mesh.vertex_corners[vertex]);
    return true;
  };
  CHECK(std::ranges::all_of(region.vertices, walks_right));
  CHECK(std::ranges::all_of(region.neighbours, [&](VertexId vertex) {
    return part.arrays().positions[vertex] == right.positions()[vertex];
  }));
}

/// Two components, a border, a vertex that no face uses, a face that is turned, and faces in
/// another order: everything that the file can have. Of several pages.
IndexedMesh with_everything() {
  IndexedMesh mesh = side_by_side({torus_grid(80, 60), sheet(40, 40), random_sheet(3, 90)});
  mesh.positions.insert(mesh.positions.begin(), Vector3<double>{});
  for (auto& face : mesh.faces)
    for (VertexId& vertex : face) ++vertex;
  std::swap(mesh.faces[7][1], mesh.faces[7][2]);
  return mesh;
}

}  // namespace

TEST_CASE("BaseIndex_OfEveryMesh_GivesBackItsArrays") {
  for (const NamedMesh& named : all_meshes()) {
    CAPTURE(named.name);
    const Indexed indexed(named.mesh);
    CHECK(same_arrays(*indexed.open(), indexed.base));
    CHECK_NOTHROW(indexed.check());
    CHECK(indexed.bytes.size() == indexed.layout().file_bytes());
  }
  const Indexed indexed(with_everything());
  CHECK(indexed.base.differs_from_input());
  CHECK(same_arrays(*indexed.open(), indexed.base));
  CHECK_NOTHROW(indexed.check());
  // Copies, other orders and maps of such a mesh are those of the mesh that was built.
  std::vector<FaceId> backwards(indexed.base.face_count());
  for (FaceId face = 0; face < backwards.size(); ++face)
    backwards[face] = static_cast<FaceId>(backwards.size() - 1 - face);
  CHECK(same_arrays(indexed.open()->with_face_order(backwards),
                    indexed.base.with_face_order(backwards)));
  CHECK(indexed.open()->input_maps().input_faces == indexed.base.input_maps().input_faces);
  CHECK(indexed.open()->input_maps().vertices == indexed.base.input_maps().vertices);
  // Maps that say nothing are not stored, as base.mesh does not keep them.
  const BaseMesh in_order = BaseMesh::build(tetrahedron());
  const BaseMesh reordered = in_order.with_face_order(std::vector<FaceId>{0, 1, 2, 3});
  write_base_index_file(indexed.directory, "other", in_order, kChecksum, false);
  write_base_index_file(indexed.directory, "reordered", reordered, kChecksum, false);
  CHECK(file_bytes(indexed.place.path() / "other") ==
        file_bytes(indexed.place.path() / "reordered"));
  std::filesystem::remove(indexed.path());
  CHECK_FALSE(indexed.open().has_value());
  CHECK_NOTHROW(indexed.check());
}

TEST_CASE("BaseIndex_OpenedForOneFace_ReadsThePagesOfThatFace") {
  const Indexed indexed(with_everything());
  const std::optional<BaseMesh> mesh = indexed.open();
  CHECK(mesh->face_count() == indexed.base.face_count());
  const std::uint64_t opened = mesh->memory_bytes();
  CHECK(opened < indexed.bytes.size() / 20);
  const auto same_face = [&](FaceId face) {
    mesh->need_face(face);
    const Topology &found = mesh->arrays().mesh, right = indexed.base.topology();
    CHECK(found.faces[face] == right.faces[face]);
    CHECK(found.face_edges[face] == right.face_edges[face]);
    for (int side = 0; side < 3; ++side)
      CHECK(found.is_own(face, side) == right.is_own(face, side));
  };
  same_face(0);
  CHECK(mesh->memory_bytes() - opened < 7 * kIndexPageBytes);
  for (FaceId face = 1; face < mesh->face_count(); ++face) same_face(face);
}

TEST_CASE("BaseIndex_WithAnyByteChanged_IsFoundBeforeItIsUsed") {
  const Indexed indexed(with_everything());
  const BaseIndexLayout layout = indexed.layout();
  // The first, the last and random bytes of each region, and of what is between regions.
  std::vector<std::uint64_t> places = {0,
                                       7,
                                       8,
                                       11,
                                       12,
                                       15,
                                       16,
                                       23,
                                       24,
                                       32,
                                       40,
                                       47,
                                       48,
                                       55,
                                       56,
                                       63,
                                       64,
                                       layout.head_bytes() - 9,
                                       layout.head_bytes() - 8,
                                       layout.head_bytes() - 1,
                                       layout.head_bytes(),
                                       indexed.bytes.size() - 1};
  std::mt19937_64 random(40);
  for (std::size_t array = 0; array < kMeshArrayCount; ++array) {
    const auto& place = layout.place(static_cast<MeshArray>(array));
    REQUIRE(place.bytes > 0);
    for (const std::uint64_t at : {std::uint64_t{0}, place.bytes - 1, place.bytes})
      if (place.offset + at < indexed.bytes.size()) places.push_back(place.offset + at);
    for (int i = 0; i < 12; ++i) places.push_back(place.offset + random() % place.bytes);
  }
  std::size_t between = 0;
  for (const std::uint64_t at : places) {
    std::vector<std::byte> changed = indexed.bytes;
    changed[at] ^= std::byte(1u << random() % 8);
    indexed.write(changed);
    CAPTURE(at);
    CHECK(code_of([&] { indexed.check(); }) == ErrorCode::kCorruption);
    try {
      const bool is_same = same_arrays(*indexed.open(), indexed.base);
      CHECK(is_same);
      ++between;
    } catch (const Error& error) {
      CHECK(error.code() == ErrorCode::kCorruption);
      CHECK(names(error, {kBaseIndexName}));
    }
    // Face by face, what is given is right.
    try {
      const std::optional<BaseMesh> mesh = indexed.open();
      for (FaceId face = 0; face < mesh->face_count(); face += 97) {
        try {
          mesh->need_face(face);
        } catch (const Error& error) {
          CHECK(error.code() == ErrorCode::kCorruption);
          continue;
        }
        CHECK(mesh->arrays().mesh.faces[face] == indexed.base.faces()[face]);
        CHECK(mesh->arrays().mesh.face_edges[face] == indexed.base.face_edges()[face]);
      }
    } catch (const Error& error) {
      CHECK(error.code() == ErrorCode::kCorruption);
    }
  }
  CHECK(between <= kMeshArrayCount + 2);  // bytes that no array has
}

TEST_CASE("BaseIndex_OfAnotherSize_IsRefusedBeforeItIsRead") {
  const Indexed indexed(with_everything());
  for (const std::uint64_t size :
       {std::uint64_t{0}, std::uint64_t{63}, std::uint64_t{64}, std::uint64_t{4096},
        std::uint64_t{indexed.bytes.size() - 1}, std::uint64_t{indexed.bytes.size() + 1},
        std::uint64_t{1} << 42}) {
    std::filesystem::resize_file(indexed.path(), size);
    CAPTURE(size);
    std::atomic<std::uint64_t> read = 0;
    const AnsweringOperations counting([&](const FileOperation& operation) {
      if (operation.kind == FileOperation::Kind::kRead) read += operation.bytes;
      return 0;
    });
    CHECK(code_of([&] { indexed.open(); }) == ErrorCode::kCorruption);
    CHECK(read <= 64);
    indexed.write(indexed.bytes);
  }
  // Counts of another mesh, and another base.mesh.
  ExpectedBase other = indexed.expected();
  ++other.checksum;
  CHECK(code_of([&] { open_base_index_file(indexed.directory, other); }) == ErrorCode::kCorruption);
  other = indexed.expected();
  other.counts.faces += 2;
  other.counts.edges += 3;
  CHECK(code_of([&] { open_base_index_file(indexed.directory, other); }) == ErrorCode::kCorruption);
}

TEST_CASE("BaseIndex_ForgedWithRightChecksums_GivesNoNumberThatLeadsAstray") {
  const Indexed indexed(with_everything());
  const Topology mesh = indexed.base.topology();
  const auto vertices = static_cast<std::uint32_t>(indexed.base.vertex_count()),
             edges = static_cast<std::uint32_t>(indexed.base.edge_count()),
             faces = static_cast<std::uint32_t>(indexed.base.face_count());
  const auto refused = [&](MeshArray array, std::size_t index, auto number) {
    indexed.write(indexed.forged(array, index, number));
    CAPTURE(static_cast<int>(array), index, number);
    CHECK(code_of([&] { indexed.open()->all_arrays(); }) == ErrorCode::kCorruption);
    CHECK(code_of([&] { indexed.check(); }) == ErrorCode::kCorruption);
  };
  refused(MeshArray::kPositions, 5, std::numeric_limits<double>::quiet_NaN());
  refused(MeshArray::kFaces, 3 * 4000, vertices);
  refused(MeshArray::kFaces, 3 * 4000, mesh.faces[4000][1]);  // a corner twice
  refused(MeshArray::kFaces, 3 * 4000, (mesh.faces[4000][0] + 1000) % vertices);
  refused(MeshArray::kFaceEdges, 3 * 5000, edges);
  refused(MeshArray::kFaceEdges, 3 * 5000, mesh.face_edges[5000][1]);
  refused(MeshArray::kFaceEdges, 3 * 5000, mesh.face_edges[1][0]);
  for (const std::size_t field : {0u, 1u}) {
    refused(MeshArray::kEdges, 4 * 900 + field, vertices);
    refused(MeshArray::kEdges, 4 * 900 + field,
            field == 0 ? mesh.edges[900].end : mesh.edges[900].start);
  }
  for (const std::size_t field : {2u, 3u}) {
    refused(MeshArray::kEdges, 4 * 900 + field, 3 * faces);
    refused(MeshArray::kEdges, 4 * 900 + field, kNoId);
    refused(MeshArray::kEdges, 4 * 900 + field, std::uint32_t{17});
  }
  refused(MeshArray::kVertexCorners, 100, 3 * faces);
  refused(MeshArray::kVertexCorners, 100, mesh.vertex_corners[101].code);
  refused(MeshArray::kBorderEdges, 2, edges);
  refused(MeshArray::kBorderEdges, 2, mesh.border_edges[1]);
  refused(MeshArray::kBorderEdges, 0, EdgeId{0});
  refused(MeshArray::kInputVertices, 9, vertices + 1);
  refused(MeshArray::kInputFaces, 9, 2 * faces);
  // What is possible by itself is not what follows from base.mesh.
  indexed.write(indexed.forged(MeshArray::kPositions, 5, 0.25));
  CHECK_NOTHROW(indexed.open()->all_arrays());
  CHECK(code_of([&] { indexed.check(); }) == ErrorCode::kCorruption);
  // One face whose edge belongs to others is refused alone.
  indexed.write(indexed.forged(MeshArray::kFaceEdges, 3 * 5000, mesh.face_edges[1][0]));
  const std::optional<BaseMesh> opened = indexed.open();
  CHECK_NOTHROW(opened->need_face(4999));
  CHECK(code_of([&] { opened->need_face(5000); }) == ErrorCode::kCorruption);
}

TEST_CASE("BaseIndex_OpenedForTheEdgesOfAPart_ReadsThePagesAroundThem") {
  const Indexed indexed(with_everything());
  const auto edges = static_cast<EdgeId>(indexed.base.edge_count());
  for (const EdgeId first : {EdgeId{0}, edges / 2, edges - 40}) {
    const std::optional<BaseMesh> opened = indexed.open();
    const BaseMesh mesh = opened->around(first, first + 40);
    check_region(indexed.base, mesh, first, first + 40);
    // A page of each of five arrays, and another one where an array is cut.
    CHECK(mesh.memory_bytes() - indexed.open()->memory_bytes() <= 10 * kIndexPageBytes);
  }
}

TEST_CASE("BaseIndex_DamagedInOnePage_ConcernsThePartsThatReadIt") {
  const Indexed indexed(with_everything());
  const BaseIndexLayout layout = indexed.layout();
  const auto edges = static_cast<EdgeId>(indexed.base.edge_count());
  std::size_t refused = 0, computed = 0;
  for (std::size_t array = 0; array < kMeshArrayCount; ++array) {
    const auto& place = layout.place(static_cast<MeshArray>(array));
    if (static_cast<MeshArray>(array) == MeshArray::kBorderEdges) continue;  // always read
    for (std::uint64_t page = 0; page < place.page_count(); ++page) {
      std::vector<std::byte> changed = indexed.bytes;
      changed[place.offset + page * kIndexPageBytes + 3] ^= std::byte{4};
      indexed.write(changed);
      CAPTURE(array, page);
      for (EdgeId first = 0; first < edges; first += edges / 5) {
        const EdgeId after = std::min(edges, first + edges / 5);
        try {
          check_region(indexed.base, indexed.open()->around(first, after), first, after);
          ++computed;
        } catch (const Error& error) {
          CHECK(error.code() == ErrorCode::kCorruption);
          CHECK(names(error, {kBaseIndexName}));
          ++refused;
        }
      }
    }
  }
  CHECK(refused > 20);
  CHECK(computed > 20);
}

TEST_CASE("BaseIndex_ForgedForAPart_IsRefusedOrGivesAPartThatEnds") {
  const Indexed indexed(with_everything());
  const Topology mesh = indexed.base.topology();
  const auto faces = static_cast<FaceId>(indexed.base.face_count());
  const auto edges = static_cast<EdgeId>(indexed.base.edge_count());
  const auto refused = [&](EdgeId first, EdgeId after, MeshArray array, std::size_t index,
                           auto number) {
    indexed.write(indexed.forged(array, index, number));
    CAPTURE(static_cast<int>(array), index, number);
    CHECK(code_of([&] { indexed.open()->around(first, after); }) == ErrorCode::kCorruption);
  };
  const EdgeId edge = 900, first = 880, after = 950;
  const FaceId face = mesh.edges[edge].own.face();
  refused(first, after, MeshArray::kFaces, 3 * face, mesh.faces[face][1]);
  refused(first, after, MeshArray::kFaceEdges, 3 * face, mesh.face_edges[face][1]);
  refused(first, after, MeshArray::kFaceEdges, 3 * face, edges - 1);
  refused(first, after, MeshArray::kEdges, 4 * edge, mesh.edges[edge].end);
  refused(first, after, MeshArray::kEdges, 4 * edge + 2, std::uint32_t{17});
  refused(first, after, MeshArray::kEdges, 4 * edge + 3, kNoId);
  refused(first, after, MeshArray::kEdges, 4 * edge + 3, 3 * (faces - 1));
  refused(first, after, MeshArray::kVertexCorners, mesh.edges[edge].start, 3 * (faces - 1));
  refused(first, after, MeshArray::kVertexCorners, mesh.edges[edge].start,
          FaceSide(face, 0).code == mesh.vertex_corners[mesh.edges[edge].start].code
              ? FaceSide(face, 1).code
              : FaceSide(face, 0).code + (mesh.faces[face][0] == mesh.edges[edge].start ? 1 : 0));
  // Anything else: an error in words, or a region around which every walk ends.
  std::mt19937 random(43);
  for (int i = 0; i < 400; ++i) {
    const auto array = static_cast<MeshArray>(1 + random() % 4);  // faces, edges, corners
    const std::size_t size = indexed.layout().place(array).bytes / 4;
    const std::uint64_t limit = array == MeshArray::kFaces       ? indexed.base.vertex_count()
                                : array == MeshArray::kFaceEdges ? edges
                                                                 : 3 * faces;
    indexed.write(
        indexed.forged(array, random() % size, static_cast<std::uint32_t>(random() % limit)));
    const auto at = static_cast<EdgeId>(random() % (edges - 2000));
    CAPTURE(i, at);
    try {
      const BaseMesh part = indexed.open()->around(at, at + 2000);
      const Topology found = part.topology();
      for (const VertexId vertex : part.region()->vertices) {
        std::size_t steps = 0;
        const FaceSide corner = found.vertex_corners[vertex];
        for (FaceSide next = found.next_corner(corner); next.exists() && next != corner;
             next = found.next_corner(next))
          if (++steps > faces) break;
        CHECK(steps <= faces);
      }
    } catch (const Error& error) {
      CHECK(error.code() == ErrorCode::kCorruption);
    }
  }
}

TEST_CASE("BaseIndex_OnADiskThatFails_IsAnErrorAndCanBeReadLater") {
  const Indexed indexed(with_everything());
  const std::optional<BaseMesh> mesh = indexed.open();
  {
    const AnsweringOperations failing(FileOperation::Kind::kRead, EIO);
    CHECK(code_of([&] { mesh->topology(); }) == ErrorCode::kIo);
    CHECK(code_of([&] { mesh->need_face(3); }) == ErrorCode::kIo);
    CHECK(code_of([&] { mesh->positions(); }) == ErrorCode::kIo);
  }
  CHECK(same_arrays(*mesh, indexed.base));
  // Cut short after it was opened: an error too, and no signal.
  const std::optional<BaseMesh> cut = indexed.open();
  std::filesystem::resize_file(indexed.path(), 8192);
  CHECK(code_of([&] { cut->topology(); }) == ErrorCode::kCorruption);
}

TEST_CASE("BaseIndex_AddedToADirectory_LeavesNothingHalfMade") {
  const Indexed indexed(octahedron());
  std::filesystem::remove(indexed.path());
  {
    const AnsweringOperations failing(FileOperation::Kind::kWrite, ENOSPC);
    CHECK(code_of([&] { add_base_index_file(indexed.directory, indexed.base, kChecksum, true); }) ==
          ErrorCode::kNoSpace);
  }
  CHECK(file_names(indexed.place.path()).empty());
  std::ofstream(indexed.place.path() / kNewBaseIndexName) << "left by a killed process";
  add_base_index_file(indexed.directory, indexed.base, kChecksum, true);
  CHECK(file_names(indexed.place.path()) == std::set<std::string>{kBaseIndexName});
  CHECK(file_bytes(indexed.path()) == indexed.bytes);
}

}  // namespace plait::test
