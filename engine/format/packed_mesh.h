// format/packed_mesh.h: the numbers of a base mesh and of its input maps, packed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "plait/base_mesh.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// REQUIRES: both counts are below kNoId.
constexpr std::uint64_t packed_mesh_bytes(std::uint64_t vertex_count, std::uint64_t face_count) {
  return 28 * vertex_count + 12 * face_count;
}

std::vector<std::byte> pack_mesh(const BaseMesh& mesh);

/// The inverse; nothing if the bytes refer to a vertex that is not there, or have vertices that no
/// face uses. A number may stand for two vertices, and positions may be anything: BaseMesh::build()
/// refuses such meshes. REQUIRES: packed_mesh_bytes() bytes.
std::optional<IndexedMesh> unpack_mesh(std::span<const std::byte> packed,
                                       std::uint64_t vertex_count, std::uint64_t face_count);

// Where vertices and faces of a base mesh are in the input, as differences of neighbours
// (docs/format.md, base.mesh).

/// REQUIRES: both counts are below kNoId.
constexpr std::uint64_t packed_maps_bytes(std::uint64_t vertex_count, std::uint64_t face_count) {
  return 4 * vertex_count + 4 * face_count;
}

std::vector<std::byte> pack_maps(const InputMaps& maps);

/// The inverse. The numbers may be anything: BaseMesh::with_input_maps() refuses wrong ones.
/// REQUIRES: packed_maps_bytes() bytes.
InputMaps unpack_maps(std::span<const std::byte> packed, std::uint64_t vertex_count,
                      std::uint64_t face_count, std::uint64_t input_vertex_count);

PLAIT_END_NAMESPACE
