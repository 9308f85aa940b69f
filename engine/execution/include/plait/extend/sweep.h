// plait/extend/sweep.h: the sweep executor. It runs passes over a store, edge by edge in layout
// order.
//
// A pass declares which levels it reads and writes. The executor pins the blocks of the window,
// calls the kernel for every edge, from several threads, and moves the window forward. A kernel
// call computes the slots of one edge. Every vertex belongs to exactly one edge, so no two calls
// write the same bytes, and the result does not depend on threads, blocks or budget.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "plait/detail/namespace.h"
#include "plait/detail/pinned_level.h"
#include "plait/progress.h"
#include "plait/store.h"

PLAIT_BEGIN_NAMESPACE

/// Which slots a kernel may access when it works on an edge.
enum class Reach : std::uint8_t {
  kOwn,    ///< the edge's own
  kFaces,  ///< also the slots of the other edges of its two faces: the Loop stencil
  kRing,   ///< also the slots of the faces across those edges: the Butterfly stencil
};

/// The levels of one attribute that a pass uses, and how it uses them.
struct LevelAccess {
  AttributeId attribute = 0;
  int first_level = 1, last_level = 0;  ///< nothing if last < first
  Access access = Access::kRead;        ///< kOverwrite and kUpdate need Reach::kOwn
  Reach reach = Reach::kOwn;
};

/// Gives a kernel access to the pinned slots. Valid during the kernel call.
class SweepView {
 public:
  /// The slot of `edge` at `level`. `access` is an index into SweepPass::accesses. REQUIRES: the
  /// pass declared the level, and `edge` is within reach of the edge of the kernel call.
  LocatedSlot slot(std::size_t access, int level, EdgeId edge) const noexcept {
    const Levels& of_access = accesses_[access];
    return of_access.levels[level - of_access.first_level].slot(edge);
  }

  template <class Record>
  std::span<Record> records(std::size_t access, int level, EdgeId edge) const noexcept {
    return slot(access, level, edge).of<Record>().records;
  }

 private:
  friend class SweepWindow;
  struct Levels {
    int first_level = 1;
    const PinnedLevel* levels = nullptr;
  };
  std::vector<Levels> accesses_;
};

/// A pass of the sweep executor: what it reads and writes, and the computation for one edge.
struct SweepPass {
  std::string name = {};  ///< for progress and errors: "odd vertices of level 3"
  std::vector<LevelAccess> accesses = {};
  /// Called once for each edge, from several threads at once (docs/threads.md); `worker` is in [0,
  /// threads). If it throws, sweep() ends with one of the exceptions.
  std::function<void(const SweepView& view, EdgeId edge, int worker)> kernel = {};
  /// Called by the thread that called sweep(), when the kernel has worked on a stretch of edges and
  /// before their slots are released. So a kernel may collect what it finds, and this function may
  /// still write to the slots of the stretch. May throw. May be empty.
  std::function<void()> stretch_done = {};
};

/// Options of sweep().
struct SweepOptions {
  int threads = 1;                 ///< 1 to 1024; 0: all processors (plait/progress.h)
  ProgressCallback progress = {};  ///< counts edges that are done; called between blocks
  /// Called when nothing can refuse the pass any more, before its first change: a work of which the
  /// pass is the first step marks there what it writes (UnfinishedLevels). May be empty.
  std::function<void()> begins = {};
  /// The kernel takes slots of all shapes, absent ones too, and takes of an absent slot nothing but
  /// its shape. Only such passes work on a store with depths (docs/adaptive.md).
  bool takes_depths = false;
};

/// The most bytes of frames that the pass pins at once. This is the smallest budget for the pass.
std::uint64_t sweep_window_bytes(Store& store, const SweepPass& pass, int threads = 1);

/// Runs the pass over all edges, or over those of the store of one part. If the budget covers the
/// window and the span of the layout, each block is read at most once. Blocks that are only written
/// are never read. Errors: kBudget before it changes anything (the message says how much is needed,
/// and for which span); kNotSupported for a store with depths; kCancelled; those of Session::pin.
void sweep(Store& store, const SweepPass& pass, const SweepOptions& options);
/// The same for a pass that only reads. Errors: also kInvalidArgument for a pass that writes.
void sweep(const Store& store, const SweepPass& pass, const SweepOptions& options);

PLAIT_END_NAMESPACE
