// Carries out a plan, step by step, and fills the result.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "plait/kernels/subdivision_job.h"
#include "plait/partial_store.h"
#include "plait/store.h"

namespace plait {

class PlannedRun {
 public:
  /// `earlier` is the store that the run goes on from, or empty. The arguments outlive this object.
  PlannedRun(const SubdivisionRequest& request, const BackendRegistry& backends,
             SubdivisionPlan& plan, std::optional<Store>& earlier, const SubdivisionWatch& watch)
      : request_(request), backends_(backends), plan_(plan), watch_(watch), store_(earlier) {}

  // The steps, in their order.

  /// The mesh that the store will have, in memory and in its order on the disk.
  BaseMesh make_base(BaseMesh mesh);
  void open_store(BaseMesh base);
  void make_levels();
  void read_back();
  void publish();

  SubdivisionResult& result() { return result_; }

 private:
  /// Tells where the run is. Errors: kCancelled if that is the answer.
  void tell(SubdivisionStep step, std::string_view phase, std::uint64_t done, std::uint64_t total);
  void enter(SubdivisionStep step) { tell(step, to_string(step), 0, 1); }

  void create_store(BaseMesh base);
  void commit();

  const SubdivisionRequest& request_;
  const BackendRegistry& backends_;
  SubdivisionPlan& plan_;
  const SubdivisionWatch& watch_;
  std::optional<PartialStore> output_;  ///< where a new store is made, unless levels are committed
  std::optional<Store>& store_;
  SubdivisionResult result_;
};

}  // namespace plait
