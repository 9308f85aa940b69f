// polygon_ears.h: divides a polygon in space into triangles, in the plane of its area vector.
// Sources: G. Meisters, "Polygons have ears", The American Mathematical Monthly 82, 1975; J.
// Shewchuk, "Adaptive precision floating-point arithmetic and fast robust geometric predicates",
// 1997 (signs of areas are exact). Pinned by tests/engine/mesh/polygon_test.cpp.
#pragma once

#include <array>
#include <span>
#include <string>

#include "plait/base_mesh.h"
#include "plait/detail/namespace.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// The most corners of a polygon that is not convex. The time grows with their square.
constexpr std::size_t kMostEarCorners = 20000;

/// Whether the triangles (first corner, two corners that follow each other) are right: each has the
/// side of the polygon, and they go around the first corner once at most. Also true where no
/// division would be better: for a polygon whose corners lie on one line, have no finite position,
/// or follow each other twice. Those who take the triangles see what is wrong there.
bool is_divided_around_first(std::span<const Vector3<double>> positions,
                             std::span<const std::array<VertexId, 3>> triangles);

/// Sets `triangles`, two fewer than the corners. Returns what is wrong with the polygon if that
/// cannot be done, such as "whose sides 0 and 2 cross".
std::string cut_ears(std::span<const Vector3<double>> positions, std::span<const VertexId> corners,
                     std::span<std::array<VertexId, 3>> triangles);

PLAIT_END_NAMESPACE
