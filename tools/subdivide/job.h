// tools/subdivide/job.h: one subdivision from a mesh file to a store, in steps that a program calls
// one after another. Says nothing by itself and handles no signals.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "partial_output.h"
#include "plait/backend.h"
#include "plait/kernels/subdivide.h"
#include "plait/layout.h"
#include "plait/store.h"
#include "subdivide/plan.h"
#include "subdivide/report.h"
#include "subdivide/request.h"

namespace plait {

struct SubdivisionEvents {
  std::function<void(const std::string&)> warning;
  std::function<bool(const SubdivideProgress&)> proceed;  ///< false cancels
};

/// Destroyed before finish() it leaves nothing but what an earlier run or --resume committed.
class SubdivisionJob {
 public:
  /// Refuses what can be refused before the mesh is read, and opens the earlier run, if there is
  /// one to go on from. Errors: kInvalidArgument, kNotSupported, kBusy, and those of Store::open.
  SubdivisionJob(SubdivisionRequest request, const BackendRegistry& backends,
                 SubdivisionEvents events);

  /// Reads the mesh, refines it in memory where slots would be too large, orders it, and compares
  /// what the run needs with what the machine has. Makes nothing, so that a process may end here
  /// at any moment. Errors: those of read_base_mesh, kOutOfMemory, kNoSpace, kInvalidArgument.
  void prepare();

  /// Makes the levels and commits: at the end, or with --resume every level. Errors: kBudget
  /// before anything is computed; kCancelled, kIo, kNoSpace.
  void refine();

  /// REQUIRES: refine().
  Store& store() { return *store_; }

  /// Closes the store and gives it its name. Errors: as PartialOutput::publish.
  void finish();

  /// Filled by the steps. Whole figures of time and memory are the caller's.
  SubdivideReport& report() { return report_; }

 private:
  void claim_name();
  void choose_backend(const BaseMesh& input);
  Store create_store(BaseMesh base);
  void commit();
  void describe();

  SubdivisionRequest request_;
  const BackendRegistry& backends_;
  SubdivisionEvents events_;
  SubdivisionPlan plan_;
  std::optional<PartialOutput> output_;  ///< where a new store is made, unless levels are committed
  std::optional<Store> store_;           ///< from prepare() on only if an earlier run is resumed
  LaidOutMesh base_;                     ///< between prepare() and refine()
  SubdivideReport report_;
};

}  // namespace plait
