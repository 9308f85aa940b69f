// Runs a plan step by step, and fills the result.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "plait/store.h"
#include "plait/subdivision_job.h"
#include "store/unpublished_store.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

class PlannedRun {
 public:
  /// `store` is the store of the earlier run, or empty; the run sets it to its own store. The
  /// arguments must outlive this object.
  PlannedRun(const SubdivisionRequest& request, const BackendRegistry& backends,
             SubdivisionPlan& plan, std::optional<Store>& store, const JobWatch& watch)
      : request_(request), backends_(backends), plan_(plan), watch_(watch), store_(store) {}

  // The steps, in their order.

  /// Returns the base mesh of the store: refined in memory, and in layout order.
  BaseMesh make_base(BaseMesh mesh);
  /// Throws the refusal of a budget that is too small before anything is committed.
  void open_store(BaseMesh base);
  void make_levels();
  /// With max_distance: copies what the depths leave, and removes the levels of all faces.
  void prune();
  void read_back();
  void publish();

  SubdivisionResult& result() { return result_; }

 private:
  /// Calls the progress callback. Returns true. Errors: kCancelled if the callback returns false.
  bool tell(const Progress& now) const;
  void enter(std::string_view step);

  void create_store(BaseMesh base);
  void describe_levels();
  void plan_levels();
  void commit();
  /// Rounds, and encodes what the passes could not encode at once.
  void encode();

  const SubdivisionRequest& request_;
  const BackendRegistry& backends_;
  SubdivisionPlan& plan_;
  const JobWatch& watch_;
  std::optional<UnpublishedStore> output_;      ///< of a new store, unless the job commits levels
  std::optional<UnpublishedStore> all_levels_;  ///< with max_distance, until prune()
  std::optional<Store>& store_;
  std::optional<PlannedSubdivision> levels_;  ///< nothing if the earlier run is finished
  SubdivisionResult result_;
};

PLAIT_END_NAMESPACE
