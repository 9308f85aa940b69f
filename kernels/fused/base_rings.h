// The base vertices of a run of faces, each with its ring (for a reach of two, both rings) at every
// level. A base vertex's rings are closed under refinement: those of a level follow from those of
// the one before it alone, whatever the valence, so irregular corners are evaluated here, once for
// all the faces around them, and a patch sees nothing but a regular grid.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "fused/lattice_buffer.h"
#include "fused/ring_shape.h"
#include "plait/kernels/rows.h"
#include "plait/topology.h"
#include "plait/vector3.h"

namespace plait {

template <class Rule>
class BaseRings;

/// What base rings are made from. The rule and all spans outlive them.
template <class Rule>
struct RingSource {
  using Real = typename Rule::Real;

  const Rule& rule;
  Topology mesh;
  std::span<const Vector3<Real>> base;
  int levels = 1;
  /// Level 1, [edge]: for a reach of two, whose rings begin there.
  std::span<const Vector3<Real>> middles = {};
  /// Rings that are evaluated already, shared by all threads: see evaluate_hubs(). May be null.
  const BaseRings<Rule>* hubs = nullptr;

  static constexpr int first_level() { return Rule::kReach - 1; }
};

template <class Rule>
class BaseRings {
 public:
  using Real = typename Rule::Real;

  explicit BaseRings(const RingSource<Rule>& source)
      : source_(source), number_of_(source.mesh.vertex_corners.size(), kNoId) {}

  /// Evaluates the vertices of these faces. REQUIRES: they descend one by one.
  void evaluate(std::span<const FaceId> faces);

  /// From this valence on a vertex is a hub: too many runs have a face of it for each of them to
  /// evaluate it anew.
  static constexpr int kHubValence = 256;
  /// Evaluates all hubs of the mesh instead of a run's vertices.
  void evaluate_hubs();
  /// Bytes that evaluate_hubs() takes.
  static std::uint64_t hub_bytes(const Topology& mesh, int levels);

  /// A base vertex at one level.
  struct View {
    const Real* first = nullptr;  ///< [point][axis][lane], at this vertex's lane
    RingShape shape;

    Vector3<Real> vertex() const { return point(0); }
    Vector3<Real> neighbour(int spoke) const {
      return point(shape.first_neighbour() + static_cast<std::size_t>(spoke));
    }

   private:
    Vector3<Real> point(std::size_t number) const {
      const Real* p = first + number * kPointNumbers;
      return {p[0], p[kPatchLanes], p[2 * kPatchLanes]};
    }
  };
  View view(std::uint32_t number, int level) const;

  /// A face's corner, and which of its neighbours is the next corner of the face.
  struct Corner {
    std::uint32_t number;  ///< among vertices()
    int spoke;
  };
  Corner corner(FaceId face, std::size_t corner) const {
    return corners_[std::size_t{3} * face + corner - first_corner_];
  }

  std::span<const VertexId> vertices() const { return vertices_; }

 private:
  struct Rings {
    const Real* first;       ///< at its lane of the first level; null until it is placed
    std::size_t neighbours;  ///< in neighbours_
    RingShape shape;
  };
  struct HubCorner {
    FaceSide corner;
    Corner at;
  };
  struct Batch {
    std::size_t first;  ///< in points_
    RingShape shape;
  };
  /// Of the last batch of one kind.
  struct Lanes {
    std::size_t next = 0, left = 0;  ///< next: in points_
  };

  void clear();
  void find(std::span<const FaceId> faces);
  template <class Visit>
  void add(VertexId vertex, Visit visit);
  const Corner* hub_at(FaceSide corner) const;
  void finish();
  void place();
  void fill_first_level();
  void fill_two_rings(std::uint32_t number, Real* to);

  RingSource<Rule> source_;
  std::vector<std::uint32_t> number_of_;  ///< [vertex] while evaluate() runs
  std::vector<VertexId> vertices_;        ///< [number]
  std::vector<Rings> rings_;
  std::vector<VertexId> neighbours_;  ///< of all of them, each counterclockwise
  std::vector<Batch> batches_;
  std::vector<Lanes> lanes_;            ///< [kind] while place() runs
  std::vector<std::uint32_t> placed_;   ///< numbers of those that are evaluated here
  std::vector<std::size_t> starts_;     ///< [number] in points_, of those
  std::uint32_t first_corner_ = 0;      ///< of the run: its code
  std::vector<Corner> corners_;         ///< [corner of the run]
  std::vector<FaceSide> next_corners_;  ///< likewise: the next counterclockwise
  std::vector<HubCorner> hub_corners_;  ///< ascending
  LatticeBuffer<Real> points_{0};
};

}  // namespace plait
