// bench/backends/measured_store.h: parts that several workloads use: opening a store as the cell
// says, what the store's files and counters tell, and the digest of slots.
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "backends/workloads.h"
#include "plait/extend/sweep.h"
#include "plait/store.h"

namespace plait::bench {

constexpr const char* kAttribute = "position";

Store open_for_reading(const WorkloadRun& run);
/// What a name of --codec stands for: a preset, or a pipeline as it is written. Errors:
/// kInvalidArgument.
Pipeline pipeline_from_name(const std::string& name);
/// A store whose blocks are encoded from others begins with the preset `fast`, as `plait subdivide`
/// does it, because the executors write all levels at once. encode_anew() ends its making.
StoreOptions options_of_new_store(const WorkloadRun& run);
void encode_anew(const WorkloadRun& run, Store& store);
/// The base mesh of the cell, in the order that every store of it has.
LaidOutMesh base_mesh(const Cell& cell);

/// {direct, engine, maps}: whether this process has files of `store` open with O_DIRECT, has an
/// io_uring, and maps such files. The kernel says so, not the backend.
nlohmann::ordered_json effective_mode(const std::filesystem::path& store);

/// A hash of a slot that does not depend on its lowest bits; all of them must be equal.
struct SlotHash {
  std::uint64_t value = 0;
  bool torn = false;  ///< the lowest bits differ
};
SlotHash slot_hash(std::span<const std::byte> slot, std::uint64_t edge, int level);

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
/// those of the codecs since the run began: {seconds, bytes, split, mode}. `run.codec_before_ns` is
/// the latter's beginning.
nlohmann::ordered_json counted(const Store& store, const WorkloadRun& run, double seconds,
                               const Needed& needed, double sync_seconds = 0);

}  // namespace plait::bench
