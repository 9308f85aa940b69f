// support/naive_subdivision.h: the oracle, with which tests compare the kernels. It subdivides
// explicit meshes in double. It is written for clarity and shares no code with the library: it has
// its own points, edges (sorted half-edges) and rings.
//
// In a refined mesh, the vertices of the coarser mesh keep their indices. The new vertices follow,
// one per edge. So the vertices that a level creates have indices from the coarser mesh's count on.
// Triangle t becomes triangles 4t .. 4t+3. So the descendants of input triangle f at level L are f
// 4^L .. (f+1) 4^L - 1, and vertex_at() finds any lattice point of a patch by descending through
// them.
//
// All functions throw std::invalid_argument for a mesh that is not an oriented 2-manifold (with or
// without border), for an index out of range, and for a vertex without triangles. Only
// Rings::find() detects several closed fans at one vertex.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace plait::naive {

using Index = std::uint32_t;
constexpr Index kNone = 0xffffffffu;

struct Point {
  double x = 0, y = 0, z = 0;
  friend constexpr bool operator==(const Point&, const Point&) = default;
  friend constexpr Point operator+(Point a, Point b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  friend constexpr Point operator-(Point a, Point b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  friend constexpr Point operator*(double s, Point a) { return {s * a.x, s * a.y, s * a.z}; }
  constexpr Point& operator+=(Point b) { return *this = *this + b; }
};

/// Corners a, b, c, counterclockwise seen from outside.
using Triangle = std::array<Index, 3>;

struct Mesh {
  std::vector<Point> points;
  std::vector<Triangle> triangles;
  int level = 0;  ///< refinements since the input
};

enum class Scheme { kLoop, kButterfly, kMidpoint };

/// One step of C. Loop, "Smooth subdivision surfaces based on triangles", 1987, with the cubic
/// B-spline curve on borders. Pinned by "NaiveLoop_*" in naive_subdivision_test.cpp.
Mesh subdivide_loop(const Mesh& mesh);

/// One step of modified Butterfly: D. Zorin, P. Schroeder, W. Sweldens, "Interpolating subdivision
/// for meshes with arbitrary topology", 1996. Vertices on a border count as regular; if a border
/// cuts off a wing of the eight-point stencil, the wing is the continuation of the triangle inside
/// in its plane; border edges use the four-point curve. Time grows with the square of an irregular
/// valence.
/// Pinned by "NaiveButterfly_*".
Mesh subdivide_butterfly(const Mesh& mesh);

/// One step that only halves edges. The surface does not change. Pinned by "NaiveMidpoint_*".
Mesh subdivide_midpoint(const Mesh& mesh);

/// `levels` steps of one scheme.
Mesh subdivide(Mesh mesh, Scheme scheme, int levels);

/// Loop's weight of each old neighbour of an interior vertex of valence n, in even positions
/// (1 - n beta) v + beta sum(neighbours).
double loop_beta(std::size_t valence);

/// The vertex at lattice point (i, j) of input triangle f: corner a is (0, 0), b (2^L, 0),
/// c (0, 2^L) for the mesh's level L. REQUIRES: i, j >= 0, i + j <= 2^L.
Index vertex_at(const Mesh& mesh, Index input_triangle, std::int64_t i, std::int64_t j);

/// All vertices of a patch, (2^L+1)(2^L+2)/2 of them: for j = 0 .. 2^L, for i = 0 .. 2^L - j.
std::vector<Index> patch_vertices(const Mesh& mesh, Index input_triangle);

/// The neighbours of a vertex, counterclockwise. Around an interior vertex they begin at the
/// smallest index; at a border vertex they go from border to border.
struct Ring {
  std::vector<Index> neighbours;
  bool closed = false;
};

/// Finds rings. Holds a reference to the mesh, which must outlive it.
class Rings {
 public:
  explicit Rings(const Mesh& mesh);
  /// O(n log n) for valence n; `ring` is reused to save allocations.
  void find(Index vertex, Ring& ring) const;
  Ring find(Index vertex) const;

 private:
  const Mesh& mesh_;
  std::vector<Index> first_;      ///< [vertex] the index of its first triangle in triangles_
  std::vector<Index> triangles_;  ///< triangles by vertex
};

}  // namespace plait::naive
