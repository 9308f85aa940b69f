// plait/kernels/subdivide.h: refine a store level by level.
#pragma once

#include <cstdint>
#include <functional>
#include <string_view>

#include "plait/base_mesh.h"
#include "plait/kernels/one_ring.h"
#include "plait/kernels/scheme.h"
#include "plait/store.h"

namespace plait {

enum class ExecutorKind : std::uint8_t {
  kFused,        ///< patch by patch through all levels, from the base mesh
  kSweep,        ///< level by level, edge by edge
  kTransparent,  ///< level by level, face by face, as a program of one's own would
};
std::string_view to_string(ExecutorKind executor) noexcept;
/// Errors: kInvalidArgument naming the executors there are.
ExecutorKind executor_from_name(std::string_view name);

struct SubdivideProgress {
  std::string_view phase;  ///< "level 3: odd vertices", "normals"; valid during the call
  std::uint64_t vertices_done, vertices_total;  ///< over the whole run, weighted by vertices
};

struct SubdivideOptions {
  Scheme scheme = Scheme::kLoop;
  /// In place of `scheme`, unless null: a rule of the program's own, by own_scheme(); outlives the
  /// call.
  const OneRingScheme* own_scheme = nullptr;
  ExecutorKind executor = ExecutorKind::kSweep;
  int levels = 1;        ///< the level to reach
  bool normals = false;  ///< attribute "normal", float32 x 3, unit length; one that is there goes
  bool limit = false;    ///< projects positions to the limit surface, if the scheme has_limits
  int threads = 1;       ///< transparent uses one, whatever is asked for
  std::function<bool(const SubdivideProgress&)> proceed = {};  ///< false cancels
  /// Positions have reached this level everywhere, and nothing is pinned: the store may be
  /// committed. Not called by the fused executor, which finishes all levels at once.
  std::function<void(int level)> level_done = {};
};

/// Gives a store that has no attribute yet its base positions: attribute "position", float32 x 3 or
/// float64 x 3 (`double_precision`), from base().positions().
void add_base_positions(Store& store, bool double_precision = false);

/// Refines attribute "position" from its finest level to `options.levels`, and records in the
/// store's provenance how, so that it can be repaired and resumed (what a program's own rule made
/// cannot be repaired: the name is all that a store keeps of the rule). Does not commit.
/// Errors: kInvalidArgument, kNotSupported (limit by a scheme without limit positions; fused in a
/// store that has levels), kBudget naming what is needed, kCancelled, kIo and kNoSpace.
void subdivide(Store& store, const SubdivideOptions& options);

/// Bytes that a subdivision of `store` keeps beside its budget: scratch per thread, and two records
/// per base edge (the rings of the base vertices) or, fused, new base records, the slots that are
/// under way at once and, for Butterfly, level 1. REQUIRES: attribute "position".
std::uint64_t subdivide_resident_bytes(const Store& store, const SubdivideOptions& options);

/// The smallest budget with which the sweep or the transparent executor brings `store` to
/// `options.levels`, so that nothing has to begin that could not end. 0 for the fused executor,
/// which refuses by itself before it touches anything. REQUIRES: attribute "position".
/// Pinned by tests/kernels/frame_needs_test.cpp.
std::uint64_t subdivide_frame_bytes(const Store& store, const SubdivideOptions& options);

/// How often a mesh must be refined beforehand so that no slot of `record_bytes` records is larger
/// than `max_slot_bytes` at `levels`.
int rebase_levels(int levels, std::uint64_t record_bytes, std::uint64_t max_slot_bytes);

/// `mesh` refined `times` times in memory: the base mesh of a store whose slots would be too large
/// without. Level numbers stay: pass `times` as StoreOptions::base_level.
BaseMesh rebase(const BaseMesh& mesh, int times, Scheme scheme, bool double_precision = false);

}  // namespace plait
