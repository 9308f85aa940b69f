// Faces around a range of edges, ring by ring.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "plait/detail/namespace.h"
#include "plait/extend/topology.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Finds the faces with an edge in a range, then those that share a vertex with the faces before,
/// and so on. Takes memory for all faces and vertices once, and then time for the faces it finds.
///
/// Where each face is refined to a grid with n steps along an edge, a vertex of the grids that is
/// in no face of ring r has more than r n steps to every vertex of ring 0: each step changes the
/// barycentric coordinates of the corners that ring r - 1 has, together, by at most 1/n, and they
/// sum up to 1 in ring r - 1 and to 0 in each face outside of ring r. Pinned by
/// tests/engine/mesh/face_rings_test.cpp.
class FaceRings {
 public:
  /// `mesh` must outlive this object.
  explicit FaceRings(const Topology& mesh);
  /// Begins anew: ring 0 has the faces with an edge in [first, after).
  void begin(EdgeId first, EdgeId after);
  /// Adds a ring. Returns false if it adds no face.
  bool grow();
  /// How often grow() was called.
  std::size_t rings() const { return ends_.size() - 1; }
  /// The faces up to this ring; of the last one if it is larger than rings().
  std::span<const FaceId> faces(std::size_t ring) const;
  /// Their edges, ascending.
  std::vector<EdgeId> edges(std::size_t ring) const;
  /// Their vertices, ascending.
  std::vector<VertexId> vertices(std::size_t ring) const;

 private:
  void add(FaceId face) {
    if (face_seen_[face] == turn_) return;
    face_seen_[face] = turn_;
    faces_.push_back(face);
  }

  Topology mesh_;
  std::uint32_t turn_ = 0;  ///< how often begin() was called
  std::vector<std::uint32_t> face_seen_, vertex_seen_;
  std::vector<FaceId> faces_;
  std::vector<std::size_t> ends_;  ///< [ring] the number of faces up to it
};

PLAIT_END_NAMESPACE
