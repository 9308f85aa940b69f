// The triangles of a semi-regular mesh at one of its levels. All levels name vertices as the finest
// one does.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "mesh/connectivity.h"
#include "plait/extend/topology.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// The finest mesh: an oriented manifold. The arrays belong to the caller.
struct FinestMesh {
  std::span<const FaceVertices> faces;
  std::span<const SideCodes> twins;  ///< as match_sides() gives them
  std::uint64_t vertex_count = 0;
};

/// A coarser level. Its faces have numbers of their own.
struct LevelMesh {
  std::vector<FaceVertices> faces;
  std::vector<SideCodes> twins;  ///< [face][side] the side across the edge, or kNoId
  /// [face][corner] the corner of the finest mesh that lies in the face and has the same vertex;
  /// empty in the finest mesh itself.
  std::vector<SideCodes> corners;
};

/// A level for reading: the finest mesh, or one that was made from it.
class LevelView {
 public:
  explicit LevelView(const FinestMesh& finest)
      : vertex_count_(finest.vertex_count), faces_(finest.faces), twins_(finest.twins) {}
  LevelView(const FinestMesh& finest, const LevelMesh& level)
      : vertex_count_(finest.vertex_count),
        faces_(level.faces),
        twins_(level.twins),
        corners_(level.corners) {}

  std::size_t face_count() const { return faces_.size(); }
  std::uint64_t vertex_count() const { return vertex_count_; }
  FaceSide twin(FaceSide side) const {
    FaceSide twin;
    twin.code = twins_[side.face()][static_cast<std::size_t>(side.side())];
    return twin;
  }
  FaceSide finest_corner(FaceSide corner) const {
    if (corners_.empty()) return corner;
    FaceSide finest;
    finest.code = corners_[corner.face()][static_cast<std::size_t>(corner.side())];
    return finest;
  }
  VertexId vertex(FaceSide corner) const {
    return faces_[corner.face()][static_cast<std::size_t>(corner.side())];
  }
  /// Begins to load the sides, or the vertices, of a face. Loads that the processor begins long
  /// before it needs the data overlap.
  void prefetch_twins(FaceId face) const { __builtin_prefetch(&twins_[face]); }
  void prefetch_vertices(FaceId face) const { __builtin_prefetch(&faces_[face]); }

 private:
  std::uint64_t vertex_count_;
  std::span<const FaceVertices> faces_;
  std::span<const SideCodes> twins_, corners_;
};

/// The side or corner that is `turn` steps further counterclockwise in the same face.
inline FaceSide turned(FaceSide at, int turn) { return {at.face(), (at.side() + turn) % 3}; }

PLAIT_END_NAMESPACE
