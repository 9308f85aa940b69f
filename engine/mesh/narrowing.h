// narrowing.h: what becomes of the positions of a mesh as numbers of float32. All commands and
// calls that make a store of a mesh ask this one measure.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "plait/attribute.h"
#include "plait/base_mesh.h"
#include "plait/detail/namespace.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// The number that float32 keeps of `number`. A function of its own, because GCC 12 drops the way
/// to float and back where it computes two numbers at once (-ftree-slp-vectorize). Pinned by
/// tests/engine/mesh/narrowing_test.cpp in the release build.
double as_float32(double number);

struct Narrowing {
  /// A vertex may move by this part of the shortest edge there.
  static constexpr double kMostOfEdge = 1e-3;

  std::uint64_t moved = 0;    ///< vertices that move by more
  std::uint64_t merged = 0;   ///< vertices that get the position of one with another position
  std::uint64_t outside = 0;  ///< vertices beyond the numbers of float32
  double farthest = 0;        ///< the largest move
  double share_of_edge = 0;   ///< the largest move in shortest edges there

  bool harms() const { return moved + merged + outside > 0; }
};

/// Vertices that are not finite, and edges without length, do not count. O(V + F). Pinned by
/// tests/engine/mesh/narrowing_test.cpp.
Narrowing narrowing_of(std::span<const Vector3<double>> positions,
                       std::span<const std::array<VertexId, 3>> faces);

/// The type for the positions of a mesh: `asked`, or else `of_file` if that is float64, or else
/// float32 unless that harms. Adds a line to `warnings` if that harms: what float32 does, and what
/// keeps the positions.
ComponentType precision_for(const IndexedMesh& mesh, std::optional<ComponentType> asked,
                            std::optional<ComponentType> of_file, std::string_view source,
                            std::vector<std::string>& warnings);
/// The same for arrays.
ComponentType precision_for(std::span<const Vector3<double>> positions,
                            std::span<const std::array<VertexId, 3>> faces,
                            std::optional<ComponentType> asked, std::string_view source,
                            std::vector<std::string>& warnings);

PLAIT_END_NAMESPACE
