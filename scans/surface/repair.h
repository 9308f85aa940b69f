// surface/repair.h: what is wrong with a triangle mesh as scanners and reconstructions make them,
// and how it becomes an oriented 2-manifold with border.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "plait/base_mesh.h"
#include "plait/detail/namespace.h"
#include "surface/surface.h"

PLAIT_BEGIN_NAMESPACE

struct SurfaceRepairOptions {
  std::uint64_t min_component = 0;  ///< components of fewer faces are removed
  std::uint64_t fill_holes = 0;     ///< the most edges of a border that is filled
};

/// What repair() found and changed. Everything is counted.
struct RepairList {
  std::uint64_t vertices = 0, faces = 0;  ///< of the mesh before
  std::uint64_t not_finite_vertices = 0;  ///< with NaN or infinite coordinates
  std::uint64_t not_finite_faces = 0;     ///< removed: they have such a vertex
  std::uint64_t degenerate_faces = 0;     ///< removed: they have a vertex twice
  std::uint64_t duplicate_faces = 0;      ///< removed: the same three vertices as an earlier face
  std::uint64_t needle_faces = 0;         ///< stay: they have no area
  std::uint64_t non_manifold_edges = 0;   ///< of more than two faces: cut apart
  std::uint64_t turned_faces = 0;         ///< against the orientation of most faces of a component
  std::uint64_t non_manifold_vertices = 0;  ///< of more than one fan: each fan got its own vertex
  std::uint64_t small_components = 0, small_component_faces = 0;  ///< removed
  std::uint64_t filled_holes = 0, filled_hole_faces = 0;          ///< added
  std::uint64_t unused_vertices = 0;                              ///< removed: no face uses them

  /// Whether the mesh was an oriented 2-manifold without unused vertices already.
  bool is_clean() const;
};

/// Whether two faces that have an edge in common fold over it: more than 150 degrees are between
/// their area vectors. A face without area has no fold.
inline bool is_folded(Point one, Point two) {
  constexpr double kCosineOf150 = -0.86602540378443865;
  return dot(one, two) < kCosineOf150 * length(one) * length(two);
}

/// Counts of a surface.
struct SurfaceFigures {
  std::uint64_t vertices = 0, edges = 0, faces = 0;
  std::uint64_t components = 0, borders = 0, border_edges = 0;
  std::int64_t euler_number = 0;   ///< vertices - edges + faces
  std::uint64_t folded_edges = 0;  ///< is_folded()
};
/// O(F).
SurfaceFigures figures_of(const Surface& surface);

struct Repaired {
  Surface surface;
  /// [vertex] the vertex of the mesh before; kNoId for one that fills a hole: its attributes are
  /// the mean of those of its neighbours with smaller numbers, which are nearer to the border.
  std::vector<VertexId> origin;
  /// [face] the face of the mesh before; kNoId for one that fills a hole.
  std::vector<FaceId> face_origin;
  RepairList list;
  /// Vertices of the mesh before, at borders of this surface, whose positions others of them have.
  std::uint64_t seam_vertices = 0;
};

/// Repairs `mesh`. A hole is filled as hole_fill.h says. O(F). Errors:
/// kInvalidArgument for an index out of range, for a component that cannot be oriented (a Moebius
/// strip), naming one of its edges, and if no face is left. `source` (a file name) begins the
/// messages. Pinned by tests/scans/repair_test.cpp.
Repaired repair(IndexedMesh mesh, const SurfaceRepairOptions& options, std::string_view source);

PLAIT_END_NAMESPACE
