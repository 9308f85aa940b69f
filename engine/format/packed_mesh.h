// format/packed_mesh.h: the numbers of a base mesh and of its input maps, packed.
#pragma once

#include <array>
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

/// Finds the words that take the fewest bytes for positions that come one after another, and give
/// their bits again.
class WordsOfPositions {
 public:
  void add(const Vector3<double>& position);
  PositionWords words() const;

 private:
  bool fit_float32_ = true, whole_ = true;
  double largest_ = 0;
  int exponent_ = PositionWords::kMostExponent + 1;
};
PositionWords words_of(std::span<const Vector3<double>> positions);
/// The word of a coordinate, of words.bytes() bytes. REQUIRES: `words` give the number again.
std::uint64_t word_of_coordinate(PositionWords words, double x);

/// The codes of corners (docs/format.md, base.mesh), corner after corner, from the places of their
/// vertices: numbers in the order in which corners name vertices first.
class CornerCodes {
 public:
  /// The place of a vertex that no corner has named.
  std::uint32_t next_place() const { return next_; }
  /// The code of the next corner. REQUIRES: place <= next_place().
  std::uint32_t code(std::uint32_t place);

 private:
  std::array<std::uint32_t, 3> before_ = {kNoId, kNoId, kNoId}, face_ = {};
  std::size_t corner_ = 0;
  std::uint32_t next_ = 0;
};

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
