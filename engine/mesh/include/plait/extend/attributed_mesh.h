// plait/extend/attributed_mesh.h: the triangles of a file together with what the file says about
// their vertices.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "plait/attribute.h"
#include "plait/base_mesh.h"
#include "plait/detail/namespace.h"

PLAIT_BEGIN_NAMESPACE

/// Records of all vertices of a mesh, or of all its triangles, one after another.
struct MeshAttribute {
  AttributeSchema schema;
  std::vector<std::byte> records;
};

/// Triangles, and attributes of their vertices. They may be invalid.
struct AttributedMesh {
  IndexedMesh mesh;
  /// The type that the coordinates of the file need: float64 for `double` of PLY, and for integers
  /// of 32 bits if float32 has not all of them; float32 for the other types of PLY and for binary
  /// STL. Text formats without types have none.
  std::optional<ComponentType> precision = {};
  std::vector<MeshAttribute> attributes = {};
  /// One number for each triangle.
  std::vector<MeshAttribute> face_attributes = {};
};

/// What a reader does with a coordinate that is infinite or no number.
enum class NotFinite : std::uint8_t { kRefuse, kKeep };
/// What a reader does with what a file says about its faces.
enum class OfFaces : std::uint8_t { kLeaveOut, kKeep };

/// read_indexed_mesh(), with the vertex properties of a PLY file as attributes of their types:
///   nx ny nz -> normal          red green blue [alpha] -> color        s t, or u v -> texture
///   NAME_0 NAME_1 ... (of one type) -> NAME, a record of as many components
///   NAME_x NAME_y NAME_z (of one type) -> NAME                 any other scalar -> its own name
/// Of OBJ, colours of all vertices become color, and texture coordinates of all corners texture (of
/// a vertex's first corner), of float32. What else a file has is left out, and a line of `warnings`
/// names it with its numbers: lists and names that an attribute cannot have, properties of faces,
/// further elements, groups, and what the other formats have beside positions. With OfFaces::kKeep,
/// scalar properties of the faces of a PLY file become face attributes of their names and types;
/// the triangles of a polygon have its numbers. Pinned by
/// tests/engine/mesh/attributed_mesh_test.cpp and left_out_test.cpp.
AttributedMesh read_attributed_mesh(const std::filesystem::path& path,
                                    std::vector<std::string>* warnings = nullptr,
                                    NotFinite not_finite = NotFinite::kRefuse,
                                    OfFaces of_faces = OfFaces::kLeaveOut);

PLAIT_END_NAMESPACE
