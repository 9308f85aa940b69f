// bench/runs/workloads.h: what `plait bench` measures. Each workload runs in a process of its
// own, on a prepared store of the cell, and returns the members of a record that only it knows.
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>

#include "instrument/disk.h"
#include "instrument/disk_floors.h"
#include "plait/extend/backend_registry.h"
#include "runs/record.h"

namespace plait::bench {

struct WorkloadRun {
  Cell cell;
  std::filesystem::path store;  ///< prepared; of `build`, the place of a new one
  std::uint64_t seed = 1;       ///< draws patches; the same for all cells of a round
  const BackendRegistry* backends = nullptr;
  std::uint64_t codec_before_ns = 0;            ///< codec_nanoseconds() when the run began
  const instrument::DiskFacts* disk = nullptr;  ///< where the store is
  instrument::Traffic disk_before;              ///< of this disk, when the run began
};

struct Workload {
  std::string_view name, summary;
  instrument::FloorKind floor;
  bool makes_store;    ///< it makes a store instead of reading one
  bool reads_all;      ///< it needs every block of the store, so the device must have read them
  bool changes_store;  ///< it writes to a store that is there
  /// Returns {seconds, bytes, split, latencies, digest, mode}; `bytes` without what the
  /// digest reads afterwards. Errors: those of a store.
  nlohmann::ordered_json (*run)(const WorkloadRun&);
};

std::span<const Workload> workloads();
/// Errors: kInvalidArgument; the message lists the known workloads.
const Workload& workload_from_name(std::string_view name);

/// Makes the store that the workloads of a cell read: the base mesh, refined, with noise in the
/// last bits of the positions, as scans have it. The bits are equal for all backends. The lowest
/// bit of each number is 0: `sweep-update` turns it. Errors: those of Store::create() and sweep().
void prepare_store(const WorkloadRun& run);

}  // namespace plait::bench
