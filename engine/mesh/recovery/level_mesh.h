// The triangles of a semi-regular mesh at one of its levels. All levels name vertices as the finest
// one does.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "io/huge_pages.h"
#include "mesh/connectivity.h"
#include "plait/extend/topology.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// The finest mesh: an oriented manifold. The arrays belong to the caller, who may have given new
/// numbers to the vertices and faces of a file. What is found does not depend on the new numbers.
struct FinestMesh {
  std::span<const FaceVertices> faces;
  std::span<const SideCodes> twins;  ///< as match_sides() gives them
  std::uint64_t vertex_count = 0;
  /// [vertex or face] its number in the file; empty if all have those.
  std::span<const VertexId> file_vertices = {};
  std::span<const FaceId> file_faces = {};

  VertexId file_vertex(VertexId vertex) const {
    return file_vertices.empty() ? vertex : file_vertices[vertex];
  }
};

/// A coarser level. Its faces have numbers of their own.
struct LevelMesh {
  HugeArray<FaceVertices> faces;
  HugeArray<SideCodes> twins;  ///< [face][side] the side across the edge, or kNoId
  /// [face][corner] the corner of the finest mesh that lies in the face and has the same vertex;
  /// empty in the finest mesh itself.
  HugeArray<SideCodes> corners;
  HugeArray<FaceId> middles;  ///< [face] the face of the file that lies in its middle
};

/// A level for reading: the finest mesh, or one that was made from it.
class LevelView {
 public:
  explicit LevelView(const FinestMesh& finest)
      : LevelView(finest, finest.faces, finest.twins, {}, finest.file_faces) {}
  LevelView(const FinestMesh& finest, const LevelMesh& level)
      : LevelView(finest, level.faces, level.twins, level.corners, level.middles) {}

  std::size_t face_count() const { return face_count_; }
  std::uint64_t vertex_count() const { return finest_.vertex_count; }
  FaceSide twin(FaceSide side) const { return from_code(twins_[side.code]); }
  FaceSide finest_corner(FaceSide corner) const {
    return corners_ == nullptr ? corner : from_code(corners_[corner.code]);
  }
  VertexId vertex(FaceSide corner) const { return vertices_[corner.code]; }
  VertexId file_vertex(FaceSide corner) const { return finest_.file_vertex(vertex(corner)); }
  /// The face of the file that lies in the middle of a face.
  FaceId file_middle(FaceId face) const { return middles_.empty() ? face : middles_[face]; }
  /// Puts faces into the order that the file gives them.
  void sort_as_in_file(std::vector<FaceId>& faces) const {
    std::ranges::sort(faces, {}, [&](FaceId face) { return file_middle(face); });
  }
  /// Begins to load the sides, or the vertices, of the face of a side. Loads that the processor
  /// begins long before it needs the data overlap.
  void prefetch_twins(FaceSide side) const { __builtin_prefetch(twins_ + side.code); }
  void prefetch_vertices(FaceSide corner) const { __builtin_prefetch(vertices_ + corner.code); }

 private:
  LevelView(const FinestMesh& finest, std::span<const FaceVertices> faces,
            std::span<const SideCodes> twins, std::span<const SideCodes> corners,
            std::span<const FaceId> middles)
      : finest_(finest),
        face_count_(faces.size()),
        vertices_(faces.empty() ? nullptr : faces[0].data()),
        twins_(twins.empty() ? nullptr : twins[0].data()),
        corners_(corners.empty() ? nullptr : corners[0].data()),
        middles_(middles) {}

  FinestMesh finest_;
  std::size_t face_count_;
  const std::uint32_t *vertices_, *twins_, *corners_;  ///< [FaceSide::code]
  std::span<const FaceId> middles_;
};

/// The side or corner that is `turn` steps, 0 to 2, further counterclockwise in the same face.
inline FaceSide turned(FaceSide at, int turn) {
  const auto steps = static_cast<std::uint32_t>(turn);
  return from_code(at.code + steps - (at.code % 3 + steps) / 3 * 3);
}

PLAIT_END_NAMESPACE
