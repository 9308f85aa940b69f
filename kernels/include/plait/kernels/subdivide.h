// plait/kernels/subdivide.h: refines a store by a subdivision scheme.
#pragma once

#include <cstdint>
#include <functional>
#include <string_view>

#include "plait/base_mesh.h"
#include "plait/kernels/one_ring.h"
#include "plait/kernels/scheme.h"
#include "plait/namespace.h"
#include "plait/store.h"

PLAIT_BEGIN_NAMESPACE

enum class ExecutorKind : std::uint8_t {
  kFused,        ///< patch by patch through all levels, from the base mesh
  kSweep,        ///< level by level, edge by edge
  kTransparent,  ///< level by level, face by face, as a user's own loops would
};
std::string_view to_string(ExecutorKind executor) noexcept;
/// Errors: kInvalidArgument; the message lists the known executors.
ExecutorKind executor_from_name(std::string_view name);

/// How far subdivide() is.
struct SubdivideProgress {
  std::string_view phase;  ///< "level 3: odd vertices", "normals"; valid during the call
  std::uint64_t vertices_done, vertices_total;  ///< over the whole run, weighted by vertices
};

/// Options of subdivide().
struct SubdivideOptions {
  Scheme scheme = kDefaultScheme;
  /// Unless nullptr, a program's own rule from own_scheme(), which replaces `scheme`. It must
  /// outlive the call.
  const OneRingScheme* own_scheme = nullptr;
  ExecutorKind executor = ExecutorKind::kSweep;
  int levels = 1;  ///< the level to reach
  /// Makes attribute "normal": float32 x 3, unit length. An existing one is replaced.
  bool normals = false;
  bool limit = false;  ///< projects positions to the limit surface, if the scheme has_limits
  int threads = 1;     ///< the transparent executor always uses one
  std::function<bool(const SubdivideProgress&)> proceed = {};  ///< false cancels
  /// Called when the positions of `level` are complete and no block is pinned, so that the program
  /// may commit the store. The fused executor does not call it, because it finishes all levels at
  /// once.
  std::function<void(int level)> level_done = {};
};

/// Adds the attribute "position" to a store that has no attribute yet, as float32 x 3 or float64 x
/// 3 (`double_precision`), and fills its base records from base().positions().
void add_base_positions(Store& store, bool double_precision = false);

/// Refines attribute "position" from its finest level to `options.levels`. Records the scheme in
/// the store's provenance, so that the store can be repaired and resumed. (Only a program that has
/// the rule can repair the levels of an own rule, because a store records only the rule's name.)
/// Does not commit. Errors: kInvalidArgument; kNotSupported (limit positions of a scheme without
/// them; the fused executor in a store that has levels); kBudget (the message names the needed
/// bytes); kCancelled, kIo and kNoSpace.
void subdivide(Store& store, const SubdivideOptions& options);

/// Bytes of memory that a subdivision of `store` uses in addition to the budget: scratch memory for
/// each thread, and two records per base edge (the rings of the base vertices). The fused executor
/// instead uses new base records, slots that wait for their second half and, for Butterfly, level
/// 1. REQUIRES: attribute "position".
std::uint64_t subdivide_resident_bytes(const Store& store, const SubdivideOptions& options);

/// The smallest budget with which the sweep or the transparent executor can refine `store` to
/// `options.levels`. So a program need not begin a run that would fail later. 0 for the fused
/// executor, which checks its budget itself before it changes anything. REQUIRES: attribute
/// "position".
/// Pinned by tests/kernels/frame_needs_test.cpp.
std::uint64_t subdivide_frame_bytes(const Store& store, const SubdivideOptions& options);

/// How often the user's mesh must be refined to make the base mesh, so that at level `levels` no
/// slot with records of `record_bytes` is larger than `max_slot_bytes`.
int rebase_levels(int levels, std::uint64_t record_bytes, std::uint64_t max_slot_bytes);

/// Refines `mesh` in memory, `times` times. The result is the base mesh for a store whose slots
/// would otherwise be too large. Level numbers do not change: pass `times` as
/// StoreOptions::base_level.
BaseMesh rebase(const BaseMesh& mesh, int times, Scheme scheme, bool double_precision = false);
/// The same by a rule of the program's own.
BaseMesh rebase(const BaseMesh& mesh, int times, const OneRingScheme& scheme,
                bool double_precision = false);

PLAIT_END_NAMESPACE
