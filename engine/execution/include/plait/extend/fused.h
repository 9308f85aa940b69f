// plait/extend/fused.h: the fused executor. It refines a patch from the base mesh to the finest
// level while the patch is in the cache. It writes each slot once, as a whole, and never reads a
// slot back.
//
// A PatchRefiner refines a group of patches. The executor walks over the faces, splits each refined
// patch into halves of slots, joins the two halves of a slot, and fills the blocks. It takes the
// faces from the last to the first. Edges are numbered by the first face that uses them, so the
// slots are completed in descending order, and each block is filled without a break, in every
// layout. The executor keeps the first half of a slot until the other face of its edge is done. The
// order of the faces decides how many halves it keeps at the same time; with a Hilbert curve there
// are few.
//
// In the store of one part (docs/many-machines.md) the executor fills the slots of the part's edges
// only. It refines the faces on both sides of these edges.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "plait/detail/namespace.h"
#include "plait/extend/edge_index.h"
#include "plait/needs.h"
#include "plait/progress.h"
#include "plait/store.h"

PLAIT_BEGIN_NAMESPACE

struct MeshPiece;

/// The limit exists because a whole patch is in memory. At 10 levels it has half a million points.
constexpr int kMostFusedLevels = 10;

/// The number of patches that are refined together, one in each lane of a vector.
constexpr std::size_t kPatchLanes = 16;

/// The points of a patch and of `halo` rows of its neighbours around it: i, j >= -halo and i + j <=
/// size + halo. They are stored row by row. A point is an array [component][lane] of numbers.
struct PatchLattice {
  std::int64_t size = 1;  ///< 2^level
  std::int64_t halo = 1;

  constexpr std::int64_t index(std::int64_t i, std::int64_t j) const {
    const std::int64_t row = j + halo;
    return row * (size + 3 * halo + 1) - row * (row - 1) / 2 + i + halo;
  }
  constexpr std::int64_t points() const { return index(-halo, size + 2 * halo + 1); }
};

/// The corner of a face that becomes corner 0 of its patch: the one with the smallest vertex index.
/// The other corners follow counterclockwise. With this rotation, side 2 belongs to the face and
/// side 1 to its neighbour (except at borders). So most patches of a group own the same sides.
constexpr int first_corner(const Topology& mesh, FaceId face) {
  const auto& [a, b, c] = mesh.faces[face];
  // Without branches, which processors would predict badly.
  return (int{b < a} & int{b < c}) + 2 * (int{c < a} & int{c < b});
}

/// Refines groups of patches by one rule. Threads: each has its own object (docs/threads.md).
class PatchRefiner {
 public:
  virtual ~PatchRefiner() = default;
  /// Begins a run: the following calls of refine() are for these faces. The face numbers descend,
  /// in a whole store in steps of one.
  virtual void begin(std::span<const FaceId> faces) = 0;
  /// Refines the `count` faces from faces[first] on, one in each lane. Each face is rotated as
  /// first_corner() says. REQUIRES: count <= kPatchLanes.
  virtual void refine(std::size_t first, std::size_t count) = 0;
  /// The result of refine() for one output: PatchLattice::points() x components x kPatchLanes
  /// numbers.
  virtual const void* points(std::size_t output) const = 0;
};

/// A pass of the fused executor: what it makes, and how.
struct FusedPass {
  std::string name = {};  ///< for progress and errors
  /// No two are equal. Their components have four or eight bytes.
  std::vector<AttributeId> outputs = {};
  /// The pass makes all levels up to this one, which is at most kMostFusedLevels finer than the
  /// base mesh.
  int finest_level = 1;
  PatchLattice lattice = {};  ///< of the finest level
  std::function<std::unique_ptr<PatchRefiner>()> make_refiner = {};
  /// For a store whose base mesh can be taken in pieces (BaseMesh::in_pieces()). If `begin_piece`
  /// is given, the pass takes one after another, and calls it before it makes refiners for the
  /// piece, whose faces then have the numbers of the piece; and `end_piece` when all its slots are
  /// made. A face at a cut is refined for more than one piece.
  std::function<void(const MeshPiece&)> begin_piece = {}, end_piece = {};
  std::uint64_t bytes_of_piece_vertex = 0;  ///< what they have in memory for each vertex of a piece
};

/// Options of fused().
struct FusedOptions {
  int threads = 1;  ///< 1 to 1024; 0: all processors (plait/progress.h)
  /// Counts faces; called between runs of faces. If the store has a parallel_for, any of its
  /// threads calls it, one at a time.
  ProgressCallback progress = {};
};

/// The most memory that a pass needs at any moment; resident: slots that wait for a second half.
Needs fused_needs(const Store& store, const FusedPass& pass, int threads);
/// The same for outputs with records of `record_bytes`. Neither they nor the levels need exist yet.
Needs fused_needs(const Store& store, std::span<const std::size_t> record_bytes, int finest_level,
                  int threads);
/// Needs::frames alone, which takes far less time.
std::uint64_t fused_frame_bytes(const Store& store, std::span<const std::size_t> record_bytes,
                                int finest_level, int threads);

/// Runs the pass: fills all levels up to pass.finest_level of every output, and reads no level. It
/// does not touch base records either; refiners may. Errors: kBudget (the message says how much is
/// needed), kInvalidArgument, kNotSupported and kBadState, all before it changes anything;
/// kCancelled; those of Session::pin; exceptions of a refiner.
void fused(Store& store, const FusedPass& pass, const FusedOptions& options);

PLAIT_END_NAMESPACE
