// bench/paper/paper_way.h: Loop subdivision as the paper does it (sections 4 and 5). A recursive
// function walks down the quadtree of each base face and reaches vertices by at(level, i, j). Each
// level takes two passes over the mesh: odd vertices, then even vertices in place. A circular
// buffer for each level holds the slots of twice the span of edges.
#pragma once

#include <cstdint>
#include <functional>

#include "plait/layout.h"
#include "plait/store.h"

namespace plait::paper {

/// Calls visit(level, i, j) for every vertex of levels `first` to `last` in a base face, once, as
/// the recursion over the face's quadtree meets it; i and j count in the grid of that level.
/// Corners of the face are not visited. Pinned by tests/bench/paper/paper_test.cpp.
void walk_patch(int first, int last,
                const std::function<void(int level, std::int64_t i, std::int64_t j)>& visit);

/// The bytes of the paper's circular buffers for positions and normals, in float32, of levels 1 to
/// `levels`: 2 span (4^levels - 1) / 3 records of each (section 4.2).
std::uint64_t circular_buffer_bytes(std::uint64_t loop_span, int levels);

/// The smallest budget with which make_in_paper_way() can run.
std::uint64_t paper_way_bytes(Store& store, int levels);

/// Refines attribute "position" (float32) of a store that has no level yet, and makes normals at
/// the end, in one pass of the transparent executor. The result has the bits of every other
/// executor. Errors: kBudget, kIo, kNoSpace.
void make_in_paper_way(Store& store, int levels);

}  // namespace plait::paper
