// format/packed_mesh.h: the numbers of a base mesh and of its input maps, packed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "plait/base_mesh.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// How the file has coordinates (docs/format.md, base.mesh). Stored: never renumber.
enum class PositionForm : std::uint32_t {
  kFloat32 = 1,  ///< the places of float32 numbers
  kFloat64 = 2,  ///< the places of float64 numbers
  kWhole = 3,    ///< whole numbers of a power of two
};
struct PositionWords {
  PositionForm form = PositionForm::kFloat64;
  std::int32_t exponent = 0;  ///< of kWhole: the numbers are multiples of 2^exponent; else 0

  /// Whether there are such words. Of kWhole, each number is finite then.
  constexpr bool valid() const {
    return form == PositionForm::kWhole ? exponent >= kLeastExponent && exponent <= kMostExponent
                                        : exponent == 0 && (form == PositionForm::kFloat32 ||
                                                            form == PositionForm::kFloat64);
  }
  constexpr std::uint64_t bytes() const { return form == PositionForm::kFloat64 ? 8 : 4; }

  static constexpr std::int32_t kLeastExponent = -1000, kMostExponent = 900;
};

/// The words that take the fewest bytes for these positions, and give their bits again.
PositionWords words_of(std::span<const Vector3<double>> positions);

/// REQUIRES: both counts are below kNoId.
constexpr std::uint64_t packed_mesh_bytes(std::uint64_t vertex_count, std::uint64_t face_count,
                                          PositionWords words) {
  return (4 + 3 * words.bytes()) * vertex_count + 12 * face_count;
}

/// REQUIRES: `words` give the mesh's positions again.
std::vector<std::byte> pack_mesh(const BaseMesh& mesh, PositionWords words);

/// The inverse; nothing if the bytes refer to a vertex that is not there, or have vertices that no
/// face uses. A number may stand for two vertices, and positions may be anything: BaseMesh::build()
/// refuses such meshes. REQUIRES: packed_mesh_bytes() bytes; words.valid().
std::optional<IndexedMesh> unpack_mesh(std::span<const std::byte> packed,
                                       std::uint64_t vertex_count, std::uint64_t face_count,
                                       PositionWords words);

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
