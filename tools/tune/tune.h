// tools/tune/tune.h: measures a store and its disk: all that the advice rests on.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string_view>

#include "plait/backends/pipeline.h"
#include "plait/store.h"
#include "tune/findings.h"

namespace plait::tune {

struct TuneOptions {
  std::filesystem::path directory;  ///< on the disk to measure
  double seconds = 60;              ///< for everything; the first round may take longer
  std::uint64_t seed = 1;
  std::size_t blocks = 16;  ///< of each attribute, at most, each as large as the largest size tried
  std::uint64_t memory_bytes = 256u << 20;  ///< for blocks that are kept
  std::uint64_t disk_bytes = 256u << 20;    ///< at most, that a run of measuring the disk moves
  int probes = 16;  ///< choices that are stored under `directory` and read, at most
  int visits = 5;   ///< of each block by each pipeline, at most
  int threads = 1;
  Goal goal = Goal::kRead;
  /// Called often, with the part that is done, 0 to 1. False ends the measurement; what there is by
  /// then is reported.
  std::function<bool(std::string_view phase, double done)> proceed;
};

/// Measures the disk, then pipelines, then how reads overlap both (probe_reads()), until
/// options.seconds have passed. The store is only read. Errors: kInvalidArgument for a store
/// without levels; kCancelled if `proceed` returned false before a pipeline was measured for each
/// attribute; those of measure_disk() and of reading.
Findings measure_store(const Store& store, const PipelineRegistry& registry,
                       const TuneOptions& options);

}  // namespace plait::tune
