// narrowing.h: what becomes of the positions of a mesh as numbers of float32. All commands and
// calls that make a store of a mesh ask this one measure.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
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
  /// A vertex of a finer level may move by this part of the edges of that level.
  static constexpr double kMostOfFinestEdge = 1e-2;

  std::uint64_t moved = 0;    ///< vertices that move by more
  std::uint64_t merged = 0;   ///< vertices that get the position of one with another position
  std::uint64_t outside = 0;  ///< vertices beyond the numbers of float32
  double farthest = 0;        ///< the largest move
  double share_of_edge = 0;   ///< the largest move in shortest edges there

  /// Vertices around which the numbers of float32 lie so far apart that vertices of the finest
  /// level move by more, even if those of the mesh itself do not move.
  std::uint64_t coarse = 0;
  double largest_step = 0;  ///< of float32 at such a vertex
  double finest_edge = 0;   ///< the longest edge of the finest level there
  int levels = 0;

  bool harms() const { return moved + merged + outside + coarse > 0; }
};

/// The lengths of the edges around a vertex. Those without length do not count.
struct EdgesOfVertex {
  double shortest = std::numeric_limits<double>::infinity();
  double longest = 0;

  void add(double length) {
    if (!(length > 0)) return;
    shortest = std::min(shortest, length);
    longest = std::max(longest, length);
  }
};

double edge_length(const Vector3<double>& a, const Vector3<double>& b);
/// The position as float32 keeps it.
Vector3<double> float32_position(const Vector3<double>& p);
bool is_finite_position(const Vector3<double>& p);
/// Adds a vertex to all that Narrowing has but `merged`. `result.levels` is set.
void add_vertex(const Vector3<double>& position, const EdgesOfVertex& edges, Narrowing& result);
/// What precision_for() says of a narrowing.
ComponentType precision_for(const Narrowing& narrowing, std::optional<ComponentType> asked,
                            std::string_view source, std::vector<std::string>& warnings);

/// What float32 does to `positions`, and to the vertices of `levels` finer levels. These lie
/// between the vertices of a face and 2^levels times closer, so what counts is half the step of
/// float32 at a vertex against the longest edge there (not the shortest: a needle of the mesh is
/// not a matter of precision). Vertices that are not finite, and edges without length, do not
/// count. O(V + F). Pinned by tests/engine/mesh/narrowing_test.cpp.
Narrowing narrowing_of(std::span<const Vector3<double>> positions,
                       std::span<const std::array<VertexId, 3>> faces, int levels = 0);

/// The largest step of float32 among coordinates whose digits seem to have been lost before: all
/// positions are numbers of float32, and for a tenth of them the last binary digit of a coordinate
/// is used, though it is worth more than a tenth of `edge`. Otherwise 0. Metres of UTM that were
/// written as float32 are such; whole numbers are not. Pinned by
/// tests/engine/mesh/narrowing_test.cpp.
double lost_step(std::span<const Vector3<double>> positions, double edge);

/// The type for the positions of a mesh: `asked`, or else `of_file` if that is float64, or else
/// float32 unless that harms the mesh or the `levels` finer levels that are made of it. Adds a line
/// to `warnings` if that harms: what float32 does, and what keeps the positions.
ComponentType precision_for(const IndexedMesh& mesh, int levels, std::optional<ComponentType> asked,
                            std::optional<ComponentType> of_file, std::string_view source,
                            std::vector<std::string>& warnings);
/// The same for arrays.
ComponentType precision_for(std::span<const Vector3<double>> positions,
                            std::span<const std::array<VertexId, 3>> faces, int levels,
                            std::optional<ComponentType> asked, std::string_view source,
                            std::vector<std::string>& warnings);

PLAIT_END_NAMESPACE
