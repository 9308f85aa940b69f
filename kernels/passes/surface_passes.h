// The passes of the library over all vertices of a store, base vertices too. Each reads positions
// of float32 x 3 or float64 x 3 and writes another attribute, which has as many levels. The bits of
// a vertex depend on what the pass reads of it and its neighbours alone.
#pragma once

#include <cstdint>
#include <string_view>

#include "passes/moved_positions.h"
#include "passes/position_box.h"
#include "plait/detail/namespace.h"
#include "plait/detail/visit_plan.h"
#include "plait/store.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

// Errors of all: those of visit_vertices(); kInvalidArgument for positions of another type.
// REQUIRES of all but box_of_positions(): options.threads is not 0.

/// Moves each vertex by `factor` of the way to the mean of its neighbours at the finest level; on a
/// border, of the two neighbours on the border. `into` has the type of positions. Counts no
/// vertex as rounded: ways become as short as one likes.
Moves smooth_positions(Store& store, std::string_view into, double factor,
                       const VisitOptions& options);

/// Moves each coordinate by length (2 u - 1). u is uniform in [0, 1), and follows from the seed and
/// from what digest() knows of the vertex: the vertex numbers of its edge's ends, its level, and
/// its place in the slot. For a base vertex both ends are the vertex itself. `into` has the type of
/// positions.
Moves add_noise(Store& store, std::string_view into, double length, std::uint64_t seed,
                const VisitOptions& options);

/// Makes unit normals by the rule of subdivide(). `positions` are float32 x 3 or float64 x 3,
/// `into` is float32 x 3.
void make_normals(Store& store, std::string_view positions, std::string_view into,
                  const VisitOptions& options);

/// The bounding box of all positions. Errors: also kInvalidArgument for a position that is not
/// finite and for a box without extent.
PositionBox box_of_positions(Store& store, const VisitOptions& options);

PLAIT_END_NAMESPACE
