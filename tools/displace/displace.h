// displace/displace.h: moves the vertices of a store, so that its surface has detail.
//
//   displace(store, {.kind = DisplacementKind::kFractal, .amplitude = 0.005});
//
// A subdivided surface is smooth and compresses far better than a scan. To test with realistic
// data, add noise (like a scan) or a fractal (like a landscape). Both are functions of the vertex
// alone, so the result has the same bits for every backend, layout, block size, budget and number
// of threads.
//
// D is the diagonal of the bounding box of all vertices, A the amplitude.
//
// Noise: each coordinate of a vertex moves by A D (2 u - 1). u is uniform in [0, 1), and follows
// from the seed and from what digest() knows of the vertex: the vertex numbers of its edge's ends,
// its level, and its place in the slot. For a base vertex both ends are the vertex itself.
//
// Fractal: a vertex moves along the normal of the surface by the sum over octaves k = 0, 1, ... of
//   A D 0.45^k g_k((p - low) / w_k),   w_k = D / 8 / 2^k,
// where p is its position, low the low corner of the bounding box, and g_k gradient noise from -1
// to 1, with another hash for each octave (K. Perlin, "Improving Noise", SIGGRAPH 2002). The last
// octave is the last one whose wavelength w_k is at least four mean edges of the finest level, so
// that the mesh can show it. The normal is that of plait/subdivide.h, from the positions
// before.
//
// Pinned by tests/tools/displace/displace_test.cpp.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "plait/progress.h"
#include "plait/store.h"

namespace plait {

enum class DisplacementKind : std::uint8_t {
  kNoise,    ///< every coordinate, uniform in +-A D
  kFractal,  ///< along the normals
};
std::string_view to_string(DisplacementKind kind) noexcept;
/// Errors: kInvalidArgument; the message lists the known kinds.
DisplacementKind displacement_from_name(std::string_view name);

/// Options of displace().
struct DisplaceOptions {
  DisplacementKind kind = DisplacementKind::kNoise;
  double amplitude = 3e-7;  ///< A, from 0 to 1, in diagonals of the bounding box
  std::uint64_t seed = 1;
  int threads = 1;                 ///< 1 to 1024
  ProgressCallback progress = {};  ///< counts visits of a vertex, over all passes
};

/// What displace() measured.
struct Displaced {
  double diagonal = 0;              ///< D, in units of the mesh
  double mean_edge = 0;             ///< of the finest level, before; 0 unless the kind is kFractal
  std::vector<double> wavelengths;  ///< of the octaves, in units of the mesh; empty for noise
  double largest_move = 0;          ///< the longest way of a vertex, in units of the mesh
};

/// Moves the vertices of all levels of attribute "position", base vertices too. If the store has an
/// attribute "normal", it is made anew from the new positions, by the rule of subdivide(). The
/// levels then no longer follow from the base mesh, so the provenance names no scheme. Does not
/// commit. Reads and writes the positions in a few passes within the budget of the store; until the
/// end they are in the store twice, the second time as "position (new)".
///
/// Errors, before anything is changed: kNotFound without "position"; kInvalidArgument unless
/// "position" is float32 x 3 or float64 x 3 and "normal", if there is one, is float32 x 3 with as
/// many levels, for options out of range, for a position that is not finite, for a box without
/// extent, and for a fractal if even w_0 is shorter than four mean edges; kBudget. Later:
/// kCancelled; kBadState for normals whose committed levels are encoded from other blocks, because
/// the pass writes all levels at once; those of Session::pin. After an error, close the store
/// without a commit.
Displaced displace(Store& store, const DisplaceOptions& wanted);

}  // namespace plait
