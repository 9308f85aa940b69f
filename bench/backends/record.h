// bench/backends/record.h: makes a record (docs/bench.md) of what a run and its surroundings gave.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "backends/cell.h"
#include "instrument/disk.h"
#include "instrument/disk_floors.h"
#include "instrument/memory_limit.h"
#include "instrument/page_cache.h"
#include "instrument/process.h"

namespace plait::bench {

/// What was seen around a run.
struct Observed {
  bool reads_all = false;   ///< the work needs every stored byte
  bool asked_cold = false;  ///< the files were to be cold
  instrument::Residency before;
  instrument::ProcessFigures process;
};

/// A run is "cold" only with two proofs: mincore before, and the bytes that the kernel says this
/// process made the disk read. Else it is "warm", or "memory" for a file system in memory. Pinned
/// by tests/bench/backends/bench_test.cpp.
struct ColdLabel {
  std::string label;
  std::string why;  ///< of "warm": which proof is missing. Without figures, so that runs can agree
};
ColdLabel cold_label(const instrument::DiskFacts& disk, const Observed& observed,
                     const nlohmann::ordered_json& result);

/// The members that are known before the run; the others are null.
nlohmann::ordered_json empty_record(const Cell& cell, int round, int order, std::uint64_t seed);
/// Fills in what the workload returned and what was observed.
void add_result(nlohmann::ordered_json& record, const nlohmann::ordered_json& result,
                const Observed& observed, const instrument::DiskFacts& disk);
/// Fills in `floor` and `ratio`, which is null if the run failed. A warm run over a cold floor has
/// no ratio, nor the reverse.
void add_floor(nlohmann::ordered_json& record, const instrument::FloorRequest& request,
               const instrument::FloorResult& floor,
               const std::optional<instrument::FloorResult>& by_fio);

}  // namespace plait::bench
