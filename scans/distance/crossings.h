// distance/crossings.h: faces of a surface that pass through other faces of it.
#pragma once

#include <cstdint>
#include <functional>

#include "distance/closest_point.h"
#include "distance/distances.h"
#include "plait/detail/namespace.h"
#include "surface/surface.h"

PLAIT_BEGIN_NAMESPACE

struct Crossings {
  std::uint64_t faces = 0;  ///< that cross another one with which they have no corner in common
  Point first{};            ///< a corner of the first of them
  /// The first faces, as many as were looked at: all, unless too many boxes overlap.
  std::uint64_t examined = 0;
};

/// The faces of `triangles`, of which `tree` is. Faces that touch do not cross. The same result for
/// any number of threads; all threads of the present arena. Each face is compared with those whose
/// boxes meet its own: few on a surface, all of them where every face reaches across all others.
/// So the work ends after 256 comparisons for each face and `most_pairs`, and the result says how
/// many faces it is of. Calls `go_on`, if it is set, now and then; what it throws ends the work.
/// Pinned by tests/scans/crossings_test.cpp.
Crossings find_crossings(const TriangleSet& triangles, const TriangleTree& tree,
                         const std::function<void()>& go_on = {},
                         std::uint64_t most_pairs = std::uint64_t{1} << 24);

PLAIT_END_NAMESPACE
