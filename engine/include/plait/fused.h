// plait/fused.h: the fused executor: every patch goes from the base mesh to the finest level in
// cache, and each slot is written once, whole, and never read back.
//
// A refinement rule says how a group of patches is refined (PatchRefiner); the executor walks the
// faces, takes the finished halves of slots apart and together, and fills the blocks. Faces are
// taken from the last to the first: edges are numbered by the first face that uses them, so slots
// are completed in descending order and a block is filled in one go, whatever the layout. What is
// under way at once are the edges between faces done and faces to come; the order of the faces
// decides how many (a Hilbert curve: few).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "plait/edge_index.h"
#include "plait/store.h"

namespace plait {

/// A patch is in memory whole: at this level half a million points.
constexpr int kMostFusedLevels = 10;

/// Patches that are refined side by side, one in each lane of a vector.
constexpr std::size_t kPatchLanes = 16;

/// The points of a patch and of `halo` rows of its neighbours around it: i, j >= -halo and
/// i + j <= size + halo. Row after row; a point takes [component][lane] numbers.
struct PatchLattice {
  std::int64_t size = 1;  ///< 2^level
  std::int64_t halo = 1;

  constexpr std::int64_t index(std::int64_t i, std::int64_t j) const {
    const std::int64_t row = j + halo;
    return row * (size + 3 * halo + 1) - row * (row - 1) / 2 + i + halo;
  }
  constexpr std::int64_t points() const { return index(-halo, size + 2 * halo + 1); }
};

/// The corner of a face that is corner 0 of its patch, the others following in turn: that of the
/// smallest vertex index. So sides 2 and 1 of a patch are, but for borders, its own and another
/// face's, and the lanes of a group seldom differ.
constexpr int first_corner(const Topology& mesh, FaceId face) {
  const auto& [a, b, c] = mesh.faces[face];
  return a < b ? (a < c ? 0 : 2) : (b < c ? 1 : 2);
}

/// A rule at work, one for each thread.
class PatchRefiner {
 public:
  virtual ~PatchRefiner() = default;
  /// The groups that follow are of these faces, which descend one by one.
  virtual void begin(std::span<const FaceId> faces) = 0;
  /// Refines faces[first], faces[first + 1] ... of the run, `count` <= kPatchLanes, lane by lane,
  /// each turned as first_corner() says.
  virtual void refine(std::size_t first, std::size_t count) = 0;
  /// What refine() made of this output: PatchLattice::points() x components x kPatchLanes numbers.
  virtual const void* points(std::size_t output) const = 0;
};

struct FusedPass {
  std::string name = {};                  ///< for progress and errors
  std::vector<AttributeId> outputs = {};  ///< each once; of components of four or eight bytes
  /// All levels to this one, at most kMostFusedLevels finer than the base mesh.
  int finest_level = 1;
  PatchLattice lattice = {};  ///< of the finest level
  std::function<std::unique_ptr<PatchRefiner>()> make_refiner = {};
};

struct FusedOptions {
  int threads = 1;  ///< 1 to 1024
  /// Called on the calling thread between runs of faces; false ends with kCancelled.
  std::function<bool(std::uint64_t faces_done, std::uint64_t face_count)> proceed = {};
};

/// What a pass needs at its widest place; the levels need not exist yet.
struct FusedNeeds {
  std::uint64_t frame_bytes = 0;  ///< of the pager's budget
  std::uint64_t slot_bytes = 0;   ///< beside it: slots under way
};
FusedNeeds fused_needs(const Store& store, const FusedPass& pass, int threads);

/// Runs the pass: fills all levels to pass.finest_level of every output, without reading any.
/// Base records are the rule's own affair. Errors: kBudget before anything is touched, saying what
/// is needed; kInvalidArgument, kNotSupported and kBadState likewise; kCancelled; those of
/// Session::pin; what a refiner throws.
void fused(Store& store, const FusedPass& pass, const FusedOptions& options);

}  // namespace plait
