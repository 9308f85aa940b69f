// distance/distances.h: how far two surfaces are from each other, in both directions (P. Cignoni,
// C. Rocchini, R. Scopigno, "Metro: measuring error on simplified surfaces", 1998).
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <string_view>
#include <vector>

#include "distance/closest_point.h"
#include "distance/far_places.h"
#include "plait/detail/namespace.h"
#include "plait/progress.h"
#include "surface/surface.h"

PLAIT_BEGIN_NAMESPACE

/// Triangles whose arrays another object owns. They may have any connectivity.
struct TriangleSet {
  std::span<const Point> positions;
  std::span<const std::array<VertexId, 3>> faces;
};

struct DistanceOptions {
  std::uint64_t samples = 1000000;
  double far = std::numeric_limits<double>::infinity();  ///< a sample beyond this distance is far
  std::string_view phase = "distances";
  ProgressCallback progress = {};  ///< counts samples; called after 32,768 samples at most
};

/// Of the samples, in units of the meshes and in degrees.
struct Distances {
  std::uint64_t samples = 0;
  double max = 0, rms = 0, mean = 0;
  double percentile_99 = 0, percentile_99_9 = 0;
  /// Between the normal of the face at the sample and that of the face at the closest point.
  double mean_angle = 0, percentile_99_angle = 0;
  double far_share = 0;              ///< of the samples
  std::vector<FarPlace> far_places;  ///< of these
};

/// From points of `from`, spread evenly by area, to the closest points of the tree's triangles
/// `to`. The same points for each number of threads. All threads of the present arena. Errors:
/// kInvalidArgument if `from` has no area, kCancelled. Pinned by tests/scans/distances_test.cpp.
Distances measure_distances(const TriangleSet& from, const TriangleTree& tree,
                            const TriangleSet& to, const DistanceOptions& options);

/// The box around the vertices that faces use; empty for no faces.
struct SurfaceBox {
  Point low{}, high{};
};
SurfaceBox box_of(const TriangleSet& triangles);
/// The length of the diagonal of this box.
double diagonal_of(const TriangleSet& triangles);
/// The mean length of the sides of the faces.
double mean_edge_of(const TriangleSet& triangles);

PLAIT_END_NAMESPACE
