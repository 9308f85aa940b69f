// sample/samples.h: the vertices of a refined base mesh as points of the scan.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "collapse/collapse_history.h"
#include "plait/base_mesh.h"
#include "plait/detail/namespace.h"
#include "plait/extend/vertex_numbering.h"
#include "plait/progress.h"
#include "surface/surface.h"

PLAIT_BEGIN_NAMESPACE

/// The numbers of the vertices of a base mesh at one level: those of VertexNumbering, by the grid
/// of the finest level. A vertex has one number, whatever the face that names it. Pinned by
/// tests/scans/sample_ring_test.cpp.
class SampleNumbers {
 public:
  /// `base` must outlive this object.
  SampleNumbers(const BaseMesh& base, int level)
      : numbering_(base.topology(), level), level_(level) {}

  std::int64_t size() const { return std::int64_t{1} << level_; }  ///< parts of an edge of the base
  std::uint64_t count() const { return numbering_.vertex_count(); }
  /// The number of the first vertex that `level` creates.
  std::uint64_t first_of(int level) const { return numbering_.first_of(level); }
  /// Vertex (i, j) of a face: i parts from corner a to b, j parts to c.
  std::uint64_t of(FaceId face, std::int64_t i, std::int64_t j) const {
    return numbering_.number({face, level_, i, j});
  }

  /// The vertex that is `part` parts of a side after its start.
  std::uint64_t on_side(FaceSide side, std::int64_t part) const {
    const std::int64_t rest = size() - part;
    switch (side.side()) {
      case 0:
        return of(side.face(), rest, part);
      case 1:
        return of(side.face(), 0, rest);
      default:
        return of(side.face(), part, 0);
    }
  }

  /// Calls work(a, b, c) for the numbers of each small triangle of a face.
  template <class Work>
  void for_each_triangle(FaceId face, Work&& work) const {
    plait::for_each_triangle(level_, [&](const std::array<FacePoint, 3>& corners) {
      work(of(face, corners[0].i, corners[0].j), of(face, corners[1].i, corners[1].j),
           of(face, corners[2].i, corners[2].j));
    });
  }

 private:
  VertexNumbering numbering_;
  int level_;
};

/// [vertex of `base` at `level`] 1: it is on one of the sides with a 1 in `sides`, or at its ends.
std::vector<std::uint8_t> vertices_on_sides(const BaseMesh& base, int level,
                                            std::span<const std::uint8_t> sides);

/// The points of the scan at all vertices of `base` at `level`, by their numbers. Face f of `base`
/// has the vertices of the face that `history` knows as history_faces[f], in the same rotation. A
/// vertex of an edge is followed back from the edge's own face. All threads of the present arena.
/// Errors: kCancelled.
std::vector<SurfacePoint> sample_scan(const CollapseHistory& history, const BaseMesh& base,
                                      std::span<const FaceId> history_faces, int level,
                                      const ProgressCallback& progress = {});

PLAIT_END_NAMESPACE
