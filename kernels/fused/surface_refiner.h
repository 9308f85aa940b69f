// Refines a group of patches from the base mesh to the finest level, with normals and limit
// positions. A subclass for each kind of rule computes a level from the coarser one.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "fused/base_rings.h"
#include "fused/patch_lattice.h"
#include "normals/normal_rules.h"
#include "plait/detail/one_ring.h"
#include "plait/detail/rows.h"
#include "plait/extend/fused.h"
#include "rows/dispatched_rows.h"
#include "schemes/butterfly.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// The results for the base vertices: [vertex]. The thread that has the first corner of a vertex
/// writes them. An empty span means that the result is not wanted. Without positions there is no
/// other result.
template <class Real>
struct BaseResults {
  std::span<Vector3<Real>> positions, limits;
  std::span<Vector3<float>> normals;
};

/// The input and the results of a refinement. The results are positions or limit positions, and
/// normals if results.normals is not empty.
template <class Rule>
struct SurfaceRefinement {
  RingSource<Rule> source;
  BaseResults<typename Rule::Real> results;
};

template <class Rule>
class SurfaceRefiner : public PatchRefiner {
 public:
  using Real = typename Rule::Real;

  explicit SurfaceRefiner(const SurfaceRefinement<Rule>& refinement);

  void begin(std::span<const FaceId> faces) final;
  void refine(std::size_t first, std::size_t count) final;
  /// Output 0: positions or limit positions; 1: normals.
  const void* points(std::size_t output) const final;

 protected:
  /// Computes `level` in fine_ from the coarser level in coarse_. Calls inject(level) for the
  /// points that rows cannot compute. The group is faces first, first + 1 ... of the run.
  virtual void refine_level(int level, std::size_t first, std::size_t count) = 0;

  const Rule& rule() const { return refinement_.source.rule; }

  /// Copies to fine_ the corners, and those points of their rings that rows cannot compute. Must be
  /// called once for each level.
  void inject(int level, std::size_t count);

  /// Calls visit(lane, side) for each side on a border.
  template <class Visit>
  void for_each_border(std::size_t first, std::size_t count, Visit visit) const {
    const Topology& mesh = refinement_.source.mesh;
    if (mesh.border_edges.empty()) return;
    for (std::size_t lane = 0; lane < count; ++lane) {
      const FaceId face = faces_[first + lane];
      const int turn = first_corner(mesh, face);
      for (int side = 0; side < 3; ++side)
        if (!mesh.across(FaceSide(face, (side + turn) % 3)).exists()) visit(lane, side);
    }
  }

  PatchLattice lattice(int level) const { return {std::int64_t{1} << level, finest_.halo}; }

  LatticeBuffer<Real> coarse_, fine_;  ///< swapped at every level; fine_ is the level in work

 private:
  /// The number of points that a rule of two rings copies around a corner.
  static constexpr std::size_t kMostCornerPoints = 9;
  struct Corner {
    const Real* rings;  ///< at the level of the next inject()
    std::size_t level_numbers;
    std::array<std::size_t, kMostCornerPoints> points;
  };

  void finish_base();
  void find_corners(std::size_t first, std::size_t count);
  void make_surface();
  void surface_borders(std::size_t first, std::size_t count);

  SurfaceRefinement<Rule> refinement_;
  NormalRow<Real> normal_row_ = normal_row<Real>();
  PatchLattice finest_;
  BaseRings<Rule> rings_;
  std::span<const FaceId> faces_;
  std::array<std::array<Corner, kPatchLanes>, 3> corners_;  ///< [corner][lane]
  LatticeBuffer<float> normals_;
  normals::BaseMasks masks_;
};

template <class Real>
std::unique_ptr<PatchRefiner> make_refiner(const SurfaceRefinement<OneRing<Real>>& refinement);
template <class Real>
std::unique_ptr<PatchRefiner> make_refiner(const SurfaceRefinement<Butterfly<Real>>& refinement);

/// The lattice of a refiner's results, and the bytes of scratch memory of a refiner without its
/// rings.
PatchLattice surface_lattice(int levels, int ring_count);
template <class Real>
std::uint64_t surface_scratch_bytes(int levels, int ring_count);

PLAIT_END_NAMESPACE
