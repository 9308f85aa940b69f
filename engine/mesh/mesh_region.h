// What of a base mesh the slots of a range of edges follow from. A part of a plan reads no more of
// a base mesh that is in a file.
#pragma once

#include <vector>

#include "plait/base_mesh.h"
#include "plait/extend/topology.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// For stencils of one ring. All lists ascend.
struct MeshRegion {
  /// That have one of the edges. Their sides, and the edges there, may be read.
  std::vector<FaceId> faces;
  /// Of these faces. A walk around one of them is inside of what may be read.
  std::vector<VertexId> vertices;
  /// Of all faces around `vertices`, so these too. find_region() reads no positions.
  std::vector<VertexId> neighbours;
  /// The other faces around `vertices`.
  std::vector<FaceId> faces_around;
};

/// Reads what the region is, if the mesh has `pages`, and checks that the arrays agree there as
/// MeshPages::need_topology() does. O(n log n) for n corners at `vertices`. REQUIRES: first <
/// after <= edges. Errors: kCorruption, kIo; kBudget if there are more faces around `vertices` than
/// `most_faces`.
MeshRegion find_region(const MeshArrays& arrays, const MeshPages* pages, EdgeId first, EdgeId after,
                       std::uint64_t most_faces = kNoId);

/// The base vertices that BaseMesh::around() keeps, or all: [index]. Threads: shared.
class VerticesAtHand {
 public:
  /// `listed` ascends; nullptr: all of `count`.
  VerticesAtHand(const std::vector<VertexId>* listed, std::size_t count)
      : listed_(listed), count_(listed != nullptr ? listed->size() : count) {}
  std::size_t size() const { return count_; }
  VertexId operator[](std::size_t index) const {
    return listed_ != nullptr ? (*listed_)[index] : static_cast<VertexId>(index);
  }

 private:
  const std::vector<VertexId>* listed_;
  std::size_t count_;
};

/// Those around which the mesh may be walked.
inline VerticesAtHand walkable_vertices(const BaseMesh& mesh) {
  return {mesh.region() != nullptr ? &mesh.region()->vertices : nullptr, mesh.vertex_count()};
}
/// Those whose positions may be read.
inline VerticesAtHand placed_vertices(const BaseMesh& mesh) {
  return {mesh.region() != nullptr ? &mesh.region()->neighbours : nullptr, mesh.vertex_count()};
}

PLAIT_END_NAMESPACE
