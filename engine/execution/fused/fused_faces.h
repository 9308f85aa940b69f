// The faces that a fused pass refines, and their order: runs of faces, each for one thread.
//
// A pass over a whole mesh takes all faces, from the last to the first. The store of one part has
// the slots of a range of edges only. Its pass takes the faces that have one of these edges. Most
// of them use one of these edges first, and their numbers are close together. The others, the
// ghosts, are faces beyond the range: the machine of another part refines them too. A ghost comes
// in a run before the face that has the other half of its slot, and close to it, so few halves
// wait.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "plait/extend/base_relative_level.h"
#include "plait/extend/fused.h"
#include "plait/extend/store_access.h"
#include "plait/extend/topology.h"
#include "plait/store.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

class FusedFaces {
 public:
  /// Runs have at most `run_faces` faces, a multiple of kPatchLanes. The last ones have fewer if
  /// there are several threads, so that none works for long when the others have ended.
  FusedFaces(const Topology& mesh, EdgeRange edges, std::uint64_t run_faces, int threads);

  std::uint64_t run_count() const { return runs_.size() - 1; }
  /// The faces of a run descend.
  std::span<const FaceId> run(std::uint64_t number) const {
    return std::span(faces_).subspan(runs_[number], runs_[number + 1] - runs_[number]);
  }
  /// In the order of the pass.
  std::span<const FaceId> all() const { return faces_; }

 private:
  std::vector<FaceId> faces_;
  std::vector<std::uint64_t> runs_;  ///< [run] its first position in faces_, and then the end
};

/// The number of levels that a fused pass makes. The sizes of its buffers depend on this number.
inline int level_count(const Store& store, const FusedPass& pass) {
  return relative_to_base(pass.finest_level, store.base_level()).refinements;
}
/// [output] the size of its records
std::vector<std::size_t> fused_record_bytes(const Store& store, const FusedPass& pass);

PLAIT_END_NAMESPACE
