// plait/subdivide.h: refines a store by a subdivision scheme.
#pragma once

#include <cstdint>
#include <functional>
#include <string_view>

#include "plait/attribute.h"
#include "plait/base_mesh.h"
#include "plait/detail/namespace.h"
#include "plait/detail/scheme.h"
#include "plait/extend/provenance.h"
#include "plait/needs.h"
#include "plait/progress.h"
#include "plait/store.h"

PLAIT_BEGIN_NAMESPACE

enum class ExecutorKind : std::uint8_t {
  kAuto,         ///< kFused where it can run and fits the budget, otherwise kSweep
  kFused,        ///< patch by patch through all levels, from the base mesh
  kSweep,        ///< level by level, edge by edge
  kTransparent,  ///< level by level, face by face, as a user's own loops would
};
std::string_view to_string(ExecutorKind executor) noexcept;
/// Errors: kInvalidArgument; the message lists the known executors.
ExecutorKind executor_from_name(std::string_view name);

/// Options of subdivide().
struct SubdivideOptions {
  Scheme scheme = {};  ///< of the library, or a rule of the program's own
  ExecutorKind executor = ExecutorKind::kAuto;
  int levels = 1;  ///< the level to reach
  /// Makes attribute "normal": float32 x 3, unit length. An existing one is replaced.
  bool normals = false;
  bool limit = false;  ///< projects positions to the limit surface, if the scheme has_limits
  /// 1 to 1024; 0: all processors. The transparent executor always uses one. Fewer are taken if the
  /// memory of all does not fit the budget of the store: see PlannedSubdivision::options().
  int threads = 1;
  /// Counts vertices of the whole run. Phases: "level 3: odd vertices", "normals".
  ProgressCallback progress = {};
  /// Called when the positions of `level` are complete and no block is pinned, so that the program
  /// may commit the store. The fused executor does not call it, because it finishes all levels at
  /// once.
  std::function<void(int level)> level_done = {};
};

/// A subdivision that the store allows, as plan_subdivision() chose it. Threads: one. REQUIRES: the
/// store stays at its address, and gets and loses no attribute and no level until run(); a commit
/// is allowed.
class PlannedSubdivision {
 public:
  /// As they were given, but with the executor and the number of threads that run() takes: as many
  /// as were asked for, or as fit the budget with their frames and, but for the first one, their
  /// scratch memory. For
  /// kAuto that is the fused executor if the store has no level yet, the levels are at most
  /// kMostFusedLevels, its frames fit the budget, and nobody wants to hear of each level
  /// (`level_done`); otherwise the sweep. Both give the same bits.
  const SubdivideOptions& options() const noexcept { return options_; }

  /// frames: of the widest pass. resident: scratch memory of one thread, and two records per base
  /// edge (the rings of the base vertices); during run() the store's budget lends that of further
  /// threads, so that the memory of the work does not grow with them. The fused executor instead
  /// uses new base records, slots that wait for their second half and, for Butterfly, level 1. Base
  /// meshes of many faces take a moment. Pinned by tests/kernels/frame_needs_test.cpp.
  Needs needs() const;

  /// Throws kBudget if the frames do not fit what the levels of the whole work leave of the budget.
  /// The message says which budget the whole work needs.
  void check_budget() const;

  /// Does the work, once. Errors: as subdivide(); kBadState if positions have got levels.
  void run();

 private:
  friend PlannedSubdivision plan_subdivision(Store& store, const SubdivideOptions& options);
  PlannedSubdivision(Store& store, const SubdivideOptions& options);
  void choose_executor();
  void take(ExecutorKind executor);
  std::uint64_t scratch_bytes(int threads) const;
  std::uint64_t frame_budget() const;
  bool makes_levels() const { return options_.levels > first_level_; }

  Store* store_;
  SubdivideOptions options_;
  AttributeId position_;
  int wanted_threads_;
  int first_level_;  ///< the finest level of the positions before the work
  Provenance provenance_;
  std::uint64_t frame_bytes_ = 0, frame_budget_ = 0;
  std::uint64_t lent_bytes_ = 0;  ///< scratch memory of all threads but the first one
};

/// Chooses how subdivide() refines the store, and changes nothing: executor, threads and memory.
/// Errors: those of subdivide() before its first change, but kBudget, which is check_budget()'s.
PlannedSubdivision plan_subdivision(Store& store, const SubdivideOptions& options);

/// Refines attribute "position" from its finest level to `options.levels`. A store that is finer
/// keeps its levels, and normals are made up to `options.levels`. Records the scheme in the store's
/// provenance, so that the store can be repaired and resumed. (Only a program that has the rule can
/// repair the levels of an own rule, because a store records only the rule's name.) Does not
/// commit.
///
/// Errors before the first change: kInvalidArgument; kNotSupported (limit positions of a scheme
/// without them; the fused executor in a store that has levels); kBadState and kBusy as
/// Store::remove_attribute(), and kBadState for a pipeline that encodes new positions from vertices
/// which the work changes later, as a scheme that moves_even and the fused executor do. kBudget:
/// the message says which budget the whole work needs. kBadState also if positions are unfinished.
/// After any later error, kCancelled, kIo and kNoSpace among them, call Store::roll_back(): until
/// then nobody can read what is unfinished, or commit the store.
/// Pinned by tests/kernels/states_test.cpp. The same as plan_subdivision(store, options).run().
void subdivide(Store& store, const SubdivideOptions& options);

/// How often the user's mesh must be refined to make the base mesh, so that at level `levels` no
/// slot with records of `record_bytes` is larger than `max_slot_bytes`.
int rebase_levels(int levels, std::uint64_t record_bytes, std::uint64_t max_slot_bytes);

/// Refines `mesh` in memory, `times` times. The result is the base mesh for a store whose slots
/// would otherwise be too large. Level numbers do not change: pass `times` to
/// Store::create() as Provenance::base_level. It computes in `precision`. Errors: kInvalidArgument,
/// as add_base_positions() too.
BaseMesh rebase(const BaseMesh& mesh, int times, const Scheme& scheme,
                ComponentType precision = ComponentType::kFloat32);

PLAIT_END_NAMESPACE
