// bench/measured_store.h: parts that several workloads use: opening a store as the cell says, what
// the store's files and counters tell, and the digest of slots.
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "bench/workloads.h"
#include "plait/stopwatch.h"
#include "plait/store.h"
#include "plait/sweep.h"

namespace plait::bench {

constexpr const char* kAttribute = "position";

Store open_for_reading(const WorkloadRun& run);
StoreOptions options_of_new_store(const WorkloadRun& run);
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

/// Adds up the hashes of the slots of levels `first` to `last` in a sweep, and tells of progress.
std::string sweep_digest(Store& store, int first, int last, int threads,
                         const std::function<bool(std::uint64_t, std::uint64_t)>& proceed = {});

/// Collects throughput over time.
class Throughput {
 public:
  explicit Throughput(std::uint64_t total_bytes) : total_bytes_(total_bytes) {}
  /// For SweepOptions::proceed.
  bool update(std::uint64_t done, std::uint64_t count);
  nlohmann::ordered_json to_json() const { return {{"seconds", seconds_}, {"bytes", bytes_}}; }

 private:
  std::uint64_t total_bytes_;
  Stopwatch clock_;
  std::vector<double> seconds_;
  std::vector<std::uint64_t> bytes_;
};

/// The members of a record that follow from the counters of a store since it was opened, and from
/// those of the codecs since the run began. `run.codec_before_ns` is the latter's beginning.
nlohmann::ordered_json counted(const Store& store, const WorkloadRun& run, double seconds,
                               double sync_seconds = 0);

}  // namespace plait::bench
