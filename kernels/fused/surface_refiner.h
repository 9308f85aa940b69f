// A group of patches refined from the base mesh to the finest level, with normals and limit
// positions.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "fused/fans.h"
#include "fused/lattice_buffer.h"
#include "fused/patch_rows.h"
#include "plait/fused.h"

namespace plait {

/// What the base vertices become, written by whichever thread has a face of theirs: [vertex].
/// Empty: not wanted.
template <class Real>
struct BaseResults {
  std::span<Vector3<Real>> positions, limits;
  std::span<Vector3<float>> normals;
};

/// What is refined, and what comes out: positions (or limit positions in their place), and normals
/// where `results` has room for those of the base vertices.
template <class Real>
struct SurfaceRefinement {
  Topology mesh;
  std::span<const Vector3<Real>> base;
  int levels = 1;
  fused_rows::PatchRows<Real> rows;
  BaseResults<Real> results;
};

template <class Real>
class SurfaceRefiner final : public PatchRefiner {
 public:
  explicit SurfaceRefiner(const SurfaceRefinement<Real>& refinement);

  void begin(std::span<const FaceId> faces) override;
  void refine(std::size_t first, std::size_t count) override;
  /// Output 0: positions or limit positions; 1: normals.
  const void* points(std::size_t output) const override;

  /// Bytes of scratch that one refiner holds, but for its fans.
  static std::uint64_t scratch_bytes(int levels);

 private:
  void finish_base();
  void find_corners(std::size_t first, std::size_t count);
  void inject(int level, std::size_t count);
  void make_odd(int level);
  void move_even(int level);
  template <class Visit>
  void for_each_border(std::size_t first, std::size_t count, Visit visit) const;
  void odd_borders(int level, std::size_t first, std::size_t count);
  void even_borders(int level, std::size_t first, std::size_t count);
  void make_surface();
  void surface_borders(std::size_t first, std::size_t count);

  struct Corner {
    const Real* fan;  ///< at the level that comes next
    std::size_t level_numbers, right, left;
  };

  SurfaceRefinement<Real> refinement_;
  PatchLattice finest_;
  Fans<Real> fans_;
  std::span<const FaceId> faces_;
  std::array<std::array<Corner, kPatchLanes>, 3> corners_;  ///< [corner][lane]
  LatticeBuffer<Real> coarse_, fine_;  ///< swapped at every level; `fine_` is the last one made
  LatticeBuffer<float> normals_;
};

/// The built-in rules, for the instruction set that is chosen at the time of the call.
template <class Real>
fused_rows::PatchRows<Real> loop_rows();
template <class Real>
fused_rows::PatchRows<Real> midpoint_rows();

}  // namespace plait
