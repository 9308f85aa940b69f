// Where the vertices and faces of a base mesh were in the mesh from which it was built.
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <new>
#include <numeric>
#include <utility>

#include "plait/base_mesh.h"
#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// [number in the input] the first place whose entry it is, or kNoId.
std::vector<std::uint32_t> inverse(std::span<const std::uint32_t> of, std::size_t count) {
  std::vector<std::uint32_t> places(count, kNoId);
  for (std::size_t at = of.size(); at-- > 0;)
    if (of[at] != kNoId) places[of[at]] = static_cast<std::uint32_t>(at);
  return places;
}

[[noreturn]] void refuse_map(std::string_view what) {
  throw Error(ErrorCode::kInvalidArgument, fmt::format("map a base mesh to its input: {}", what));
}

}  // namespace

InputMaps BaseMesh::input_maps() const try {
  needed(MeshArray::kInputVertices);
  const MeshArrays& arrays = needed(MeshArray::kInputFaces);
  InputMaps maps;
  maps.input_vertices.assign(arrays.input_vertices.begin(), arrays.input_vertices.end());
  if (maps.input_vertices.empty()) {
    maps.input_vertices.resize(vertex_count());
    std::iota(maps.input_vertices.begin(), maps.input_vertices.end(), VertexId{0});
  }
  maps.input_faces.resize(face_count());
  maps.turned.resize(face_count());
  FaceId most = 0;
  for (FaceId face = 0; face < face_count(); ++face) {
    const std::uint32_t entry = arrays.input_faces.empty() ? 2 * face : arrays.input_faces[face];
    maps.input_faces[face] = entry / 2;
    maps.turned[face] = entry % 2 != 0;
    most = std::max(most, entry / 2);
  }
  maps.input_vertex_count = arrays.input_vertex_count;
  maps.vertices = inverse(maps.input_vertices, arrays.input_vertex_count);
  maps.faces = inverse(maps.input_faces, face_count() > 0 ? most + std::size_t{1} : 0);
  return maps;
} catch (const std::bad_alloc&) {
  throw out_of_memory("map a base mesh to its input");
}

BaseMesh BaseMesh::with_input_maps(const InputMaps& maps) && {
  if (maps.input_vertices.size() != vertex_count() || maps.input_faces.size() != face_count() ||
      maps.turned.size() != face_count())
    refuse_map(fmt::format("expected {} vertices and {} faces, found {} and {}", vertex_count(),
                           face_count(), maps.input_vertices.size(), maps.input_faces.size()));
  bool same_vertices = maps.input_vertex_count == vertex_count(), same_faces = true;
  for (VertexId vertex = 0; vertex < vertex_count(); ++vertex) {
    const VertexId found = maps.input_vertices[vertex];
    if (found != kNoId && found >= maps.input_vertex_count)
      refuse_map(fmt::format("vertex {}: expected a vertex below {}, found {}", vertex,
                             maps.input_vertex_count, found));
    same_vertices = same_vertices && found == vertex;
  }
  std::vector<std::uint32_t> faces(face_count());
  for (FaceId face = 0; face < face_count(); ++face) {
    const FaceId found = maps.input_faces[face];
    if (found >= face_count())
      refuse_map(
          fmt::format("face {}: expected a face below {}, found {}", face, face_count(), found));
    faces[face] = 2 * found + (maps.turned[face] ? 1 : 0);
    same_faces = same_faces && faces[face] == 2 * face;
  }
  struct Maps {
    std::vector<VertexId> vertices;
    std::vector<std::uint32_t> faces;
  };
  const auto owned = std::make_shared<Maps>();
  if (!same_vertices) owned->vertices = maps.input_vertices;
  if (!same_faces) owned->faces = std::move(faces);
  arrays_.input_vertices = owned->vertices;
  arrays_.input_vertex_count = maps.input_vertex_count;
  arrays_.input_faces = owned->faces;
  maps_owner_ = owned;
  return std::move(*this);
}

PLAIT_END_NAMESPACE
