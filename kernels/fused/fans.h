// The base vertices of a run of faces, each with its ring at every level. A base vertex's ring is
// closed under refinement: the ring at a level follows from the one before it alone, whatever the
// valence, so irregular corners are evaluated here, once for all the faces around them, and a patch
// sees nothing but a regular grid.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "fused/patch_rows.h"
#include "plait/topology.h"
#include "plait/vector3.h"

namespace plait {

template <class Real>
class Fans {
 public:
  Fans(const Topology& mesh, std::span<const Vector3<Real>> base, int levels,
       const fused_rows::PatchRows<Real>& rows)
      : mesh_(mesh),
        base_(base),
        levels_(levels),
        rows_(rows),
        fan_of_(mesh.vertex_corners.size(), kNoId) {}

  /// Evaluates the vertices of these faces. REQUIRES: they descend one by one.
  void evaluate(std::span<const FaceId> faces);

  /// A base vertex at one level: point(0) is itself, 1 to `valence` its ring.
  struct View {
    const Real* first = nullptr;  ///< [point][axis][lane], at this vertex's lane
    int valence = 0;
    bool border = false;
    Vector3<Real> point(int number) const {
      const Real* p = first + static_cast<std::size_t>(number) * fused_rows::kPointNumbers;
      return {p[0], p[kPatchLanes], p[2 * kPatchLanes]};
    }
  };
  View view(std::uint32_t number, int level) const;

  /// A face's corner, and which of its neighbours is the next corner of the face.
  struct Corner {
    std::uint32_t fan;
    int spoke;
  };
  Corner corner(std::size_t face_in_run, std::size_t corner) const {
    return corners_[face_in_run][corner];
  }

  std::span<const VertexId> vertices() const { return vertices_; }

 private:
  struct Fan {
    std::size_t first;  ///< of its batch in points_, plus its lane
    std::size_t ring;   ///< in rings_
    int valence;
    bool border;
  };
  struct Batch {
    std::size_t first;
    int valence;
    bool border;
  };

  void find(std::span<const FaceId> faces);
  void place();
  void fill_level_0();

  Topology mesh_;
  std::span<const Vector3<Real>> base_;
  int levels_;
  fused_rows::PatchRows<Real> rows_;
  std::vector<std::uint32_t> fan_of_;  ///< [vertex] while evaluate() runs
  std::vector<VertexId> vertices_;     ///< [fan]
  std::vector<Fan> fans_;
  std::vector<VertexId> rings_;  ///< neighbours, counterclockwise
  std::vector<Batch> batches_;
  std::vector<std::array<Corner, 3>> corners_;  ///< [face of the run]
  std::vector<Real> points_;
};

}  // namespace plait
