// export/gltf_records.h: how a record of the store becomes numbers of a glTF file.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "plait/attribute.h"
#include "plait/detail/namespace.h"
#include "plait/store.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

using GltfVector = std::array<double, 3>;

enum class GltfConversion : std::uint8_t {
  kCopy,
  kPosition,   ///< less the translation of the node, as float32
  kLattice,    ///< the same in steps of the lattice
  kUnit,       ///< of length 1, as float32
  kUnitBytes,  ///< of length 1, -1 to 1 as -127 to 127
  kColor,      ///< to linear numbers from 0 to 1, of 16 bits or float32
  kTexture,    ///< t counts from the lower border, in the file from the upper one
  kNarrow,     ///< float64 to float32
};

/// One attribute of the file.
struct GltfColumn {
  AttributeId attribute = 0;
  std::string semantic;
  GltfConversion conversion = GltfConversion::kCopy;
  int component = 0;  ///< the number that glTF has for the type
  bool normalized = false;
  bool srgb = false;  ///< the colours of the store are
  std::uint32_t components = 3;
  std::size_t stride = 0;    ///< bytes from one vertex to the next, a multiple of 4
  std::uint64_t offset = 0;  ///< of the first vertex in the numbers of the file
};

/// A position is translation + step * record. Step and translation are multiples of powers of two,
/// so that readers with float32 numbers for a node keep them.
struct GltfPlacement {
  bool z_up = false;   ///< z of the store points upwards, which glTF calls y
  bool moves = false;  ///< the node has a translation
  bool lattice = false;
  GltfVector translation{};
  double step = 1;
};

struct GltfBounds {
  GltfVector low{}, high{};
};
GltfBounds no_bounds() noexcept;
void extend(GltfBounds& bounds, const GltfVector& point) noexcept;

/// A record of three floats, turned so that y points upwards: (x, y, z) becomes (x, z, -y).
GltfVector vector_of(std::span<const std::byte> record, ComponentType type, bool z_up) noexcept;
/// `vector` with the length 1; nothing for a vector without a direction, such as zero.
std::optional<GltfVector> direction_of(const GltfVector& vector) noexcept;
/// Whether the length is 1 but for the rounding of numbers in float32 or in decimals.
bool is_unit(const GltfVector& vector) noexcept;
/// A number of a record of float32, float64, or of uint8 and uint16 as 0 to 1.
double number_of(std::span<const std::byte> record, ComponentType type,
                 std::uint32_t component) noexcept;

/// Writes the numbers of one record to `numbers`, which are zero. Returns what a position is in
/// these numbers, and extends `error` by how far that is from where the position was.
GltfVector convert_record(std::span<const std::byte> record, ComponentType type,
                          const GltfColumn& column, const GltfPlacement& placement,
                          std::span<std::byte> numbers, double& error) noexcept;

PLAIT_END_NAMESPACE
