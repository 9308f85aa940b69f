// The mesh of an import, from the file to its levels.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "import/local_order.h"
#include "mesh/connectivity.h"
#include "mesh/recovery/recover_levels.h"
#include "plait/base_mesh.h"
#include "plait/extend/attributed_mesh.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Its arrays take the memory of the import. The positions are the first attribute.
struct FineMesh {
  std::vector<FaceVertices> faces;  ///< of the file; empty if `local` has them
  std::vector<CutFace> cut_faces;   ///< of the file
  LocalMesh local;
  std::vector<SideCodes> twins;
  std::vector<MeshAttribute> attributes;  ///< of the vertices as the file numbers them
  std::uint64_t vertex_count = 0;

  FinestMesh view() const {
    if (local.faces.empty()) return {faces, twins, vertex_count};
    return {local.faces, twins, vertex_count, local.file_vertices, local.file_faces};
  }
};

/// Bytes for each vertex, of an import that has `attribute_bytes` for each: read as numbers of
/// float64, and then connected.
constexpr std::uint64_t import_bytes_per_vertex(std::uint64_t attribute_bytes) {
  // Two faces for each vertex: 24 bytes of corners, 24 of sides, and 28 to find them; 12 bytes of
  // the order.
  return 88 + attribute_bytes;
}

/// Vertices of the file as its header or its size tell; 0 if that is not known.
std::uint64_t expected_vertices(const std::filesystem::path& path);

/// Errors: kInvalidArgument if a coordinate is beyond `precision`.
FineMesh fine_mesh(AttributedMesh read, ComponentType precision, const std::string& source);
/// Finds the sides, and gives the mesh a local order. Errors: kInvalidArgument unless the mesh is
/// an oriented manifold.
void connect(FineMesh& mesh, const std::string& source, std::vector<std::string>& warnings);
/// Vertices of borders whose positions others of them have. REQUIRES: connect() has passed.
std::uint64_t seam_vertices(const FineMesh& mesh);

/// Sets `records` to the attribute's records of these vertices.
void gather_records(const MeshAttribute& attribute, std::span<const VertexId> vertices,
                    std::vector<std::byte>& records);

/// A base mesh, and where the patch of each face begins in the fine mesh.
struct ImportedBase {
  BaseMesh mesh;
  std::vector<FaceSide> corners;  ///< [face]
};
ImportedBase imported_base(const FineMesh& mesh, const LevelMesh& level, const std::string& source);

PLAIT_END_NAMESPACE
