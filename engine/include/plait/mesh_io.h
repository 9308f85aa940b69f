// plait/mesh_io.h: base meshes from and to files.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "plait/base_mesh.h"
#include "plait/file.h"

namespace plait {

/// Reads PLY (ascii, binary of both endians, any property order and types, unknown elements
/// skipped), OBJ (negative and slashed indices) or OFF, each also as .gz and .zst. The format
/// is taken from the content's first bytes, and from the file name only where these say nothing
/// (OBJ). Polygons are fanned into triangles, which adds a line to `warnings` if that is given.
/// Memory is bounded by what the file really holds, whatever its header promises.
/// Errors: kNotFound or kIo for the file, kInvalidArgument for its content, each naming file,
/// line or byte offset, element, expected and found.
IndexedMesh read_indexed_mesh(const std::filesystem::path& path,
                              std::vector<std::string>* warnings = nullptr);

/// read_indexed_mesh, then BaseMesh::build.
BaseMesh read_base_mesh(const std::filesystem::path& path,
                        std::vector<std::string>* warnings = nullptr);

/// Writes binary little-endian PLY (float x y z, list uchar int vertex_indices). The file appears
/// under its name only when it is whole and on the disk; a failure leaves what was there before.
/// Errors: kInvalidArgument for a position outside float32 or an index out of range, kIo, kNoSpace.
void write_ply(const std::filesystem::path& path, const IndexedMesh& mesh);
/// Into a file that is open and empty.
void write_ply(File& file, const IndexedMesh& mesh);

}  // namespace plait
