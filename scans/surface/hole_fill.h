// surface/hole_fill.h: the faces that fill a hole.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "plait/detail/namespace.h"
#include "surface/surface.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Vertices and faces of a fill. The vertices of the border come first, in their order.
struct HoleFill {
  std::vector<Point> inner;  ///< vertices that are new
  std::vector<std::array<VertexId, 3>> faces;
};

/// Fills a hole of any number of edges, which runs along `border` as a border of the surface does.
/// Rings of half as many vertices each lie between the border and the mean of its vertices, so no
/// new vertex has more than 9 neighbours, and a vertex of the border gets at most 2 more. The new
/// vertices are in the order from the border inwards. Up to 8 edges are a fan. O(edges). Pinned by
/// tests/scans/repair_test.cpp.
HoleFill fill_hole(std::span<const Point> border);

PLAIT_END_NAMESPACE
