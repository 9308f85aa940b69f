// The base vertices of a run of faces, each with its ring (for a scheme of two rings, both) at
// every level. The rings of a base vertex at one level depend only on its rings at the coarser
// level, for any valence. So this class evaluates the irregular corners once for all faces around
// them, and a patch is a regular grid.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "fused/patch_lattice.h"
#include "plait/base_mesh.h"
#include "plait/detail/numbers.h"
#include "plait/detail/rows.h"
#include "plait/extend/topology.h"
#include "plait/extend/vector3.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

template <class Rule>
class BaseRings;

/// The input of base rings. The rule and all spans must outlive them.
template <class Rule>
struct RingSource {
  using Real = typename Rule::Real;

  const Rule& rule;
  Topology mesh;
  std::span<const Vector3<Real>> base;
  int levels = 1;
  /// The vertices of level 1: [edge]. Only for a scheme of two rings, where the rings begin at
  /// level 1.
  std::span<const Vector3<Real>> middles = {};
  /// Rings that all threads share: see evaluate_hubs(). May be nullptr.
  const BaseRings<Rule>* hubs = nullptr;
  /// The positions in double, as imported. Only if `base` is empty.
  std::span<const Vector3<double>> imported = {};

  Vector3<Real> vertex(VertexId number) const {
    return base.empty() ? narrow<Real>(imported[number]) : base[number];
  }
  void prefetch(VertexId number) const {
    base.empty() ? __builtin_prefetch(&imported[number]) : __builtin_prefetch(&base[number]);
  }

  static constexpr int first_level() { return Rule::kRingCount - 1; }
};

template <class Rule>
class BaseRings {
 public:
  using Real = typename Rule::Real;

  explicit BaseRings(const RingSource<Rule>& source) : source_(source) {}

  /// Evaluates the vertices of these faces. It is fastest if their numbers descend one by one.
  /// REQUIRES: they descend. The span stays valid until the next call.
  void evaluate(std::span<const FaceId> faces);

  /// A vertex of this valence or more is a hub. Many runs have a face at a hub, so its rings are
  /// evaluated once for all runs.
  static constexpr int kHubValence = 256;
  /// Of the base vertices at hand (mesh/mesh_region.h), ascending.
  static std::vector<VertexId> find_hubs(const BaseMesh& mesh);
  /// The same for some vertices, around which the mesh may be walked.
  static std::vector<VertexId> find_hubs(const Topology& mesh, std::span<const VertexId> vertices);
  /// Evaluates these hubs, instead of the vertices of a run.
  void evaluate_hubs(std::span<const VertexId> hubs);
  /// The bytes that evaluate_hubs() needs.
  static std::uint64_t hub_bytes(const BaseMesh& mesh, int levels);

  /// A base vertex at one level.
  struct View {
    const Real* first = nullptr;  ///< [point][axis][lane]; points to the lane of this vertex
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

  /// The vertex at a corner of a face, and the spoke that leads to the next corner of the face.
  struct Corner {
    std::uint32_t number;  ///< index into vertices()
    int spoke;
  };
  Corner corner(FaceId face, std::size_t corner) const {
    return corners_[place_of(FaceSide(face, static_cast<int>(corner)))];
  }

  std::span<const VertexId> vertices() const { return vertices_; }

 private:
  struct Rings {
    const Real* first;       ///< its lane at the first level; nullptr before place()
    std::size_t neighbours;  ///< index into neighbours_
    RingShape shape;
  };
  /// The edge from the vertex of a face's corner to the face's next corner.
  struct Spoke {
    FaceSide next;  ///< the corner at the same vertex in the next face counterclockwise
    VertexId neighbour;
  };
  struct HubCorner {
    FaceSide corner;
    Corner at;
  };
  struct Batch {
    std::size_t first;  ///< index into points_
    RingShape shape;
  };
  /// The free lanes of the last batch of one kind of vertices.
  struct Lanes {
    std::size_t next = 0, left = 0;  ///< `next` is an index into points_
  };

  void clear();
  void find(std::span<const FaceId> faces);
  template <class Visit>
  void add(VertexId vertex, Visit visit);
  const Corner* hub_at(FaceSide corner) const;
  /// Index into corners_; at least their number if the face is not in the run.
  std::uint32_t place_of(FaceSide corner) const {
    return one_by_one_ ? corner.code - first_corner_ : place_among(corner);
  }
  std::uint32_t place_among(FaceSide corner) const;
  void find_spokes();
  Spoke spoke_at(FaceId face, std::uint32_t corner) const;
  Spoke spoke_at(FaceSide corner) const {
    return spoke_at(corner.face(), static_cast<std::uint32_t>(corner.side()));
  }
  void finish();
  void place();
  void fill_first_level();
  void fill_two_rings(std::uint32_t number, Real* to);

  RingSource<Rule> source_;
  std::vector<VertexId> vertices_;  ///< [number]
  std::vector<Rings> rings_;
  std::vector<VertexId> neighbours_;  ///< of all vertices, counterclockwise for each; grows only
  std::size_t neighbour_count_ = 0;
  std::vector<Batch> batches_;
  std::vector<Lanes> lanes_;           ///< [kind] while place() runs
  std::vector<std::uint32_t> placed_;  ///< numbers of the vertices that this object evaluates
  std::vector<std::size_t> starts_;    ///< [number] index into points_, for the placed vertices
  std::span<const FaceId> faces_;      ///< of the run
  bool one_by_one_ = true;             ///< no face is missing between them
  std::uint32_t first_corner_ = 0;     ///< the code of the first corner of the run
  std::vector<Corner> corners_;        ///< [corner of the run] number kNoId: not found yet
  std::vector<std::uint32_t> hub_numbers_;  ///< [hub] its number in the run, or kNoId
  std::vector<Spoke> spokes_;               ///< [corner of the run]
  std::vector<HubCorner> hub_corners_;      ///< ascending
  LatticeBuffer<Real> points_{0};
};

PLAIT_END_NAMESPACE
