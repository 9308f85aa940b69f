// Detail as of a landscape: waves of all lengths along the normals of a surface.
//
// A vertex at p moves along the normal there, by the rule of subdivide(), by the sum over octaves
// k = 0, 1, ... of
//   A 0.45^k g_k((p - low) / w_k),   w_k = D / 8 / 2^k,
// where A is the amplitude, D the diagonal of the bounding box of all vertices, low the low corner
// of the box, and g_k gradient noise from -1 to 1, with another hash for each octave (K. Perlin,
// "Improving Noise", SIGGRAPH 2002). The last octave is the last one whose wavelength w_k is at
// least four mean edges of the finest level, so that the mesh can show it.
//
// Pinned by tests/jobs/pass_moves_test.cpp.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "passes/moved_positions.h"
#include "passes/position_box.h"
#include "plait/detail/namespace.h"
#include "plait/store.h"
#include "plait/visit_vertices.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// The waves that a surface can show, in units of the mesh.
struct Waves {
  double mean_edge = 0;         ///< of the finest level
  std::vector<double> lengths;  ///< of the octaves, longest first
};

/// Visits all positions. The sum of the edges does not depend on threads. Errors: those of
/// visit_vertices(); kInvalidArgument if even the first wave is shorter than four mean edges.
Waves measure_waves(Store& store, const PositionBox& box, const VisitOptions& options);

/// Writes the moved positions to `into`, which has their type. `amplitude` is a length. Errors:
/// those of visit_vertices().
Moves add_fractal(Store& store, std::string_view into, double amplitude, std::uint64_t seed,
                  const PositionBox& box, const Waves& waves, const VisitOptions& options);

PLAIT_END_NAMESPACE
