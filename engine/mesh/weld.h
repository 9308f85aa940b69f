// weld.h: vertices at equal places. Files that have a vertex for each corner of a seam of texture
// or normals, or of each triangle, fall apart there: every such edge is a border.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "plait/base_mesh.h"
#include "plait/detail/namespace.h"
#include "plait/extend/attributed_mesh.h"

PLAIT_BEGIN_NAMESPACE

/// How many of these vertices have the position of another one of them. REQUIRES: each is there
/// once.
std::uint64_t coinciding_vertices(const std::vector<Vector3<double>>& positions,
                                  std::span<const VertexId> vertices);

/// How many vertices of borders have the position of another one of these.
std::uint64_t seam_vertices_of(const BaseMesh& mesh);

/// "N vertices have positions that others have: seams", and what closes them. Empty for 0.
std::string seam_text(std::uint64_t vertices, std::string_view remedy = "--weld makes them one");

/// Each vertex that is at most `tolerance` from an earlier one that stays becomes the nearest such
/// one; 0: only if the positions are equal. The vertices that stay are numbered anew, in their
/// order. Vertices that are not finite stay. Returns how many became others, and adds lines to
/// `warnings`: their number, and for each attribute how many of them had another record than the
/// vertex that they became. The same result for any number of threads. O(V + F) for tolerances
/// below the edges. Errors: kInvalidArgument for a tolerance that is negative or not finite.
/// `source` (a file name) begins the messages. Pinned by tests/engine/mesh/weld_test.cpp.
std::uint64_t weld(AttributedMesh& read, double tolerance, std::string_view source,
                   std::vector<std::string>& warnings);

PLAIT_END_NAMESPACE
