#include "import/fine_mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <iterator>
#include <numeric>
#include <span>
#include <system_error>
#include <utility>

#include "address/record_sizes.h"
#include "base/interruption.h"
#include "io/huge_pages.h"
#include "mesh/files/ply_header.h"
#include "mesh/weld.h"
#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// A text file has a line of about thirty bytes for a vertex and two such lines for its faces.
constexpr std::uint64_t kTextBytesPerVertex = 90;
/// A binary STL file has two facets of fifty bytes for each vertex.
constexpr std::uint64_t kStlBytesPerVertex = 100;

template <class Real>
std::vector<std::byte> narrowed(std::span<const Vector3<double>> positions,
                                const std::string& source) {
  std::vector<std::byte> records = huge_vector<std::byte>(positions.size() * sizeof(Vector3<Real>));
  for (std::size_t vertex = 0; vertex < positions.size(); ++vertex) {
    const Vector3<double>& p = positions[vertex];
    const Vector3<Real> narrow = {static_cast<Real>(p.x), static_cast<Real>(p.y),
                                  static_cast<Real>(p.z)};
    if (!std::isfinite(narrow.x) || !std::isfinite(narrow.y) || !std::isfinite(narrow.z))
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("{}: vertex {}: expected a position within float32, found ({}, {}, "
                              "{}): take float64",
                              source, vertex, p.x, p.y, p.z));
    std::memcpy(records.data() + vertex * sizeof narrow, &narrow, sizeof narrow);
  }
  return records;
}

Vector3<double> position_of(const MeshAttribute& positions, VertexId vertex) {
  const std::byte* const record =
      positions.records.data() + vertex * positions.schema.record_bytes();
  Vector3<double> wide;
  if (positions.schema.type == ComponentType::kFloat64) {
    std::memcpy(&wide, record, sizeof wide);
    return wide;
  }
  Vector3<float> narrow;
  std::memcpy(&narrow, record, sizeof narrow);
  return {narrow.x, narrow.y, narrow.z};
}

HugeArray<std::uint32_t> cells_of(const MeshAttribute& positions, std::uint64_t vertex_count) {
  PlaceGrid grid;
  for (VertexId vertex = 0; vertex < vertex_count; ++vertex)
    grid.include(position_of(positions, vertex));
  HugeArray<std::uint32_t> cells(vertex_count);
  for (VertexId vertex = 0; vertex < vertex_count; ++vertex)
    cells[vertex] = grid.cell(position_of(positions, vertex));
  return cells;
}

/// Returns false, and leaves the mesh as it was, if there is an error, which has to name elements
/// of the file, or if the faces do not agree in orientation.
bool connect_in_local_order(FineMesh& mesh) {
  mesh.local = local_mesh(mesh.faces, cells_of(mesh.attributes[0], mesh.vertex_count));
  try {
    MatchedSides sides =
        match_sides(mesh.local.faces, mesh.vertex_count, "", std::exchange(mesh.faces, {}));
    mesh.twins = std::move(sides.twins);
    if (sides.oriented && sides.has_plain_fans) return true;
  } catch (const Error&) {  // said again in the order of the file
  }
  mesh.twins = {};
  mesh.faces = faces_of_file(std::exchange(mesh.local, {}));
  return false;
}

}  // namespace

std::uint64_t expected_vertices(const std::filesystem::path& path) {
  std::error_code unknown;
  const std::uint64_t bytes = std::filesystem::file_size(path, unknown);
  if (unknown) return 0;
  Input input(path);
  input.ensure(3);
  if (input.unread().starts_with("ply")) {
    const PlyHeader header = read_ply_header(input);
    const auto vertices = std::ranges::find(header.elements, "vertex", &PlyElement::name);
    return vertices == header.elements.end()
               ? 0
               : input.plausible_count(vertices->count, vertices->least_bytes());
  }
  const std::string extension = path.extension().string();
  if (extension == ".gz" || extension == ".zst") return 0;
  return bytes / (extension == ".stl" ? kStlBytesPerVertex : kTextBytesPerVertex);
}

FineMesh fine_mesh(AttributedMesh read, ComponentType precision, const std::string& source) {
  FineMesh mesh;
  mesh.vertex_count = read.mesh.positions.size();
  const std::vector<Vector3<double>> positions = std::move(read.mesh.positions);
  MeshAttribute& position = mesh.attributes.emplace_back();
  position.schema = {"position", precision, 3};
  position.records = precision == ComponentType::kFloat64 ? narrowed<double>(positions, source)
                                                          : narrowed<float>(positions, source);
  std::ranges::move(read.attributes, std::back_inserter(mesh.attributes));
  mesh.faces = std::move(read.mesh.faces);
  mesh.cut_faces = std::move(read.mesh.cut_faces);
  return mesh;
}

void connect(FineMesh& mesh, const std::string& source, std::vector<std::string>& warnings) {
  const MeshSource names(source, mesh.cut_faces);
  if (mesh.faces.empty())
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("{}: expected at least one face, found none", source));
  const std::size_t triangles = mesh.faces.size();
  check_faces(mesh.faces, mesh.vertex_count, names);
  if (connect_in_local_order(mesh)) return;
  MatchedSides sides = match_sides(mesh.faces, mesh.vertex_count, names);
  if (!sides.oriented) {
    const std::uint64_t flipped = make_orientation_consistent(mesh.faces, sides.twins, names);
    warnings.push_back(
        fmt::format("{}: {} of {} faces flipped to the orientation of the first "
                    "face of their component",
                    source, flipped, names.face_count(triangles)));
  }
  if (!sides.has_plain_fans) find_vertex_corners(mesh.faces, sides.twins, mesh.vertex_count, names);
  mesh.twins = std::move(sides.twins);
}

std::uint64_t seam_vertices(const FineMesh& mesh) {
  const FinestMesh finest = mesh.view();
  std::vector<VertexId> on_border;
  for (FaceId face = 0; face < finest.twins.size(); ++face)
    for (std::size_t side = 0; side < 3; ++side)
      if (finest.twins[face][side] == kNoId)
        for (const std::size_t corner : {(side + 1) % 3, (side + 2) % 3})
          on_border.push_back(finest.file_vertex(finest.faces[face][corner]));
  std::ranges::sort(on_border);
  on_border.erase(std::unique(on_border.begin(), on_border.end()), on_border.end());
  std::vector<Vector3<double>> positions;
  for (const VertexId vertex : on_border)
    positions.push_back(position_of(mesh.attributes[0], vertex));
  std::iota(on_border.begin(), on_border.end(), VertexId{0});
  return coinciding_vertices(positions, on_border);
}

void gather_records(const MeshAttribute& attribute, std::span<const VertexId> vertices,
                    std::vector<std::byte>& records) {
  constexpr std::size_t kAhead = 16;
  const std::size_t bytes = attribute.schema.record_bytes();
  const std::byte* const from = attribute.records.data();
  records.resize(vertices.size() * bytes);
  std::byte* to = records.data();
  const auto copy_all = [&](auto copy) {
    for (std::size_t at = 0; at < vertices.size(); ++at, to += bytes) {
      if (at + kAhead < vertices.size()) __builtin_prefetch(from + vertices[at + kAhead] * bytes);
      copy(from + vertices[at] * bytes);
    }
  };
  if (!with_record_size(bytes, [&](auto record) {
        copy_all([&](const std::byte* source) { std::memcpy(to, source, sizeof record); });
      }))
    copy_all([&](const std::byte* source) { std::memcpy(to, source, bytes); });
}

ImportedBase imported_base(const FineMesh& mesh, const LevelMesh& level,
                           const std::string& source) {
  const FinestMesh finest = mesh.view();
  const LevelView view(finest, level);
  std::vector<VertexId> vertices;  // of the base mesh as the file names them, ascending
  vertices.reserve(3 * view.face_count());
  std::vector<FaceId> faces(view.face_count());
  std::iota(faces.begin(), faces.end(), FaceId{0});
  view.sort_as_in_file(faces);
  for (const FaceId face : faces)
    for (int corner = 0; corner < 3; ++corner) vertices.push_back(view.file_vertex({face, corner}));
  poll_interruption();
  std::ranges::sort(vertices);
  poll_interruption();
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());

  IndexedMesh base;
  ImportedBase result;
  for (const VertexId vertex : vertices)
    base.positions.push_back(position_of(mesh.attributes[0], vertex));
  std::uint64_t turn = 0;
  for (const FaceId face : faces) {
    if (is_turn_to_poll(++turn)) poll_interruption();
    FaceVertices& corners = base.faces.emplace_back();
    for (int corner = 0; corner < 3; ++corner)
      corners[static_cast<std::size_t>(corner)] = static_cast<VertexId>(
          std::ranges::lower_bound(vertices, view.file_vertex({face, corner})) - vertices.begin());
    result.corners.push_back(view.finest_corner({face, 0}));
  }
  result.mesh = BaseMesh::build(std::move(base), source);
  return result;
}

PLAIT_END_NAMESPACE
