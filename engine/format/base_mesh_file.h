// The file base.mesh: the imported positions, and the faces in layout order, packed
// (format/packed_mesh.h) and compressed; then where they were in the input (format/packed_mesh.h).
// Byte table: docs/format.md.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "format/packed_mesh.h"
#include "plait/base_mesh.h"
#include "plait/extend/directory.h"
#include "plait/extend/file.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

struct StoredSize {
  std::uint64_t bytes = 0, checksum = 0;
};

/// Creates the file and syncs it: a copy, if the mesh comes from files that have it packed. Errors:
/// kCorruption if these are damaged; kIo, kNoSpace, kNotSupported as refuse_bomb().
StoredSize write_base_mesh_file(const Directory& store, const BaseMesh& mesh);

/// What the file begins with. `input_vertex_count` is 0 if there is no second frame.
std::vector<std::byte> base_mesh_header(std::uint64_t vertex_count, std::uint64_t face_count,
                                        std::uint64_t input_vertex_count, PositionWords words);
/// Throws kNotSupported for a file so small that readers would take it for one that is made to take
/// their memory.
void refuse_bomb(const std::filesystem::path& path, std::uint64_t file_bytes,
                 std::uint64_t vertex_count, std::uint64_t face_count, PositionWords words);

/// The bytes of the file for packed_mesh_bytes() bytes of a mesh.
std::vector<std::byte> base_mesh_file(std::uint64_t vertex_count, std::uint64_t face_count,
                                      PositionWords words, std::span<const std::byte> packed);
/// Adds packed_maps_bytes() bytes of maps. REQUIRES: input_vertex_count > 0.
void append_input_maps(std::vector<std::byte>& file, std::uint64_t input_vertex_count,
                       std::span<const std::byte> packed);

/// Size, checksum and counts are those of the store's version. Takes memory for these counts only
/// if the file can have them. Errors: kCorruption for another size, checksum or header, for a frame
/// that does not decode to these numbers of vertices and faces, and for a mesh that BaseMesh
/// refuses; kOutOfMemory if the machine has less memory available than the mesh needs.
BaseMesh read_base_mesh_file(const File& file, const StoredSize& expected,
                             std::uint64_t vertex_count, std::uint64_t face_count);

PLAIT_END_NAMESPACE
