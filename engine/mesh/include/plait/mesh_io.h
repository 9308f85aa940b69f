// plait/mesh_io.h: reads and writes base meshes as files.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "plait/base_mesh.h"
#include "plait/detail/namespace.h"
#include "plait/extend/file.h"

PLAIT_BEGIN_NAMESPACE

/// Reads PLY (ascii, binary of both endians, any property order and types, unknown elements
/// skipped), OBJ (negative and slashed indices), OFF or STL (corners with equal positions become
/// one vertex), each also as .gz and .zst. The first bytes of the content decide which format it
/// is; the file name decides only if they do not (OBJ, STL). A polygon is divided into triangles:
/// around its first corner if all of them have the side of the polygon, else by cutting ears in its
/// plane. That adds a line to `warnings` if the caller gave `warnings`. Memory
/// grows with the data that the file really contains, not with the counts in its header. Errors:
/// kNotFound or kIo for the file, kInvalidArgument for its content, each naming file, line or byte
/// offset, element, expected and found.
IndexedMesh read_indexed_mesh(const std::filesystem::path& path,
                              std::vector<std::string>* warnings = nullptr);

/// read_indexed_mesh, then BaseMesh::build. A line of `warnings` names what the file has beside
/// positions and faces, which is left out.
BaseMesh read_base_mesh(const std::filesystem::path& path,
                        std::vector<std::string>* warnings = nullptr);

/// Writes binary little-endian PLY (float x y z, list uchar int vertex_indices). The file gets its
/// name only when it is complete and on the disk. After a failure, an older file of that name is
/// unchanged.
/// Errors: kInvalidArgument for a position outside float32 or an index out of range, kIo, kNoSpace.
void write_ply(const std::filesystem::path& path, const IndexedMesh& mesh);
/// Writes the same content into a file that is open and empty.
void write_ply(File& file, const IndexedMesh& mesh);

PLAIT_END_NAMESPACE
