// tools/mpi/job.h: what plait-mpi does, without its command line.
#pragma once

#include <cstdint>
#include <exception>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "mpi/part_queue.h"
#include "mpi/ranks.h"
#include "plait/extend/backend_registry.h"
#include "plait/extend/parts.h"

namespace plait::mpi {

struct JobOptions {
  std::filesystem::path plan;
  std::filesystem::path store;  ///< empty: only the parts
  PartOptions part;
  std::vector<std::string> plugins;
  bool json = false;
};

std::string host_name();

/// What all ranks do while MPI runs, and then rank 0 alone: no rank waits for the join.
class Job {
 public:
  Job(const JobOptions& options, const BackendRegistry& backends)
      : options_(options), backends_(backends) {}

  /// While MPI runs. A rank on which `prepare` throws makes no parts.
  void run(const Ranks& ranks, const std::function<void()>& prepare);
  /// Afterwards. Returns the exit status. Errors: those of run(), and of join_parts().
  int end() const;

 private:
  const JobOptions& options_;
  const BackendRegistry& backends_;
  PartsPlan plan_;
  std::optional<PartQueue> queue_;  ///< of rank 0
  std::exception_ptr error_;
  int ranks_ = 1;
  double seconds_ = 0;
};

}  // namespace plait::mpi
