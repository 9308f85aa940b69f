// bench/runs/measured_store.h: parts that several workloads use: opening a store as the cell
// says, what the store's files and counters tell, and the digest of slots.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "plait/attribute.h"
#include "plait/extend/sweep.h"
#include "plait/store.h"
#include "runs/workloads.h"

namespace plait::bench {

constexpr const char* kAttribute = "position";
inline const AttributeSchema kSchema{kAttribute, ComponentType::kFloat32, 3};

Store open_store(const WorkloadRun& run, bool writable = false);
/// What a name of --codec stands for: a preset, or a pipeline as it is written. Errors:
/// kInvalidArgument.
Pipeline pipeline_from_name(const std::string& name);
/// All levels of the base mesh, not committed. Store::finish_encoding() ends the making.
Store refined_store(const WorkloadRun& run, const LaidOutMesh& base);
/// The base mesh of the cell, in the order that every store of it has.
LaidOutMesh base_mesh(const Cell& cell);

/// A sweep over all levels of the cell: kernel(words of a slot, edge, level, worker) for each slot.
template <class Kernel>
void sweep_slots(Store& store, const Cell& cell, Access access, Kernel kernel) {
  SweepPass pass;
  pass.name = cell.workload;
  pass.accesses = {{store.attribute(kAttribute), 1, cell.levels, access, Reach::kOwn}};
  pass.kernel = [&](const SweepView& view, EdgeId edge, int worker) {
    for (int level = 1; level <= cell.levels; ++level)
      kernel(view.records<std::uint32_t>(0, level, edge), edge, level, worker);
  };
  sweep(store, pass, {.threads = cell.threads});
}

/// The digest of all slots of the cell's levels, whichever way the lowest bits are turned, by a
/// sweep; "torn" if they are turned in one part of a slot and not in another.
std::string sweep_digest(Store& store, const Cell& cell);

/// The member `latencies` of a record: count and quantiles. null if there was no request.
nlohmann::ordered_json latencies_to_json(std::vector<double> seconds);

/// Raw bytes that a workload asked for. What a request needs beyond its patch depends on the
/// blocks; without `read`, what the pager read counts.
struct Needed {
  std::optional<std::uint64_t> read;
  std::uint64_t written = 0;
};
/// The members of a record that follow from the counters of a store since it was opened, and from
/// those of the codecs since the run began: {seconds, bytes, split, mode}.
nlohmann::ordered_json counted(const Store& store, const WorkloadRun& run, double seconds,
                               const Needed& needed, double sync_seconds = 0);

}  // namespace plait::bench
