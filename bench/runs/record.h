// bench/runs/record.h: a cell of the table of `plait bench`, which is one measurement that
// every round repeats, and the record (docs/measuring.md) of what a run of it and its surroundings
// gave.
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "instrument/disk.h"
#include "instrument/page_cache.h"
#include "instrument/process.h"
#include "runs/floors.h"

namespace plait::bench {

/// docs/measuring.md explains the members.
struct Cell {
  std::string backend = "pread", pipeline = "none";
  std::string disk;  ///< a name that no other disk of the plan has
  std::filesystem::path directory;
  std::string workload;
  /// The name of the base mesh: of a file, with a checksum of the mesh. Empty: a torus.
  std::string mesh = {};
  std::filesystem::path mesh_file = {};
  std::uint64_t base_vertices = 0;
  std::uint64_t vertices = 0;  ///< of all levels
  int levels = 4;
  std::uint64_t memory_bytes = 0, budget_bytes = 0, block_bytes = 1 << 20;
  int threads = 1;
  bool is_auto = false;  ///< `auto` would choose this backend here; no part of the key

  /// Bytes of the levels before compression: float32 positions.
  std::uint64_t raw_bytes() const { return vertices * 12; }
};

/// The member `cell` of a record, and its `key`. Neither says where the disk's directory or the
/// mesh's file is: the same measurement in another directory has the same key.
nlohmann::ordered_json to_json(const Cell& cell);
std::string key_of(const Cell& cell);
/// Cells with equal names share a prepared store.
std::string store_name(const Cell& cell);
/// Names the surface that the levels of the cell are: "2000 vertices at level 3". Runs of equal
/// names have the same data, whatever backend they have.
std::string surface_name(const Cell& cell);

/// What was seen around a run.
struct Observed {
  bool reads_all = false;   ///< the work needs every stored byte
  bool asked_cold = false;  ///< the files were to be cold
  instrument::Residency before;
  instrument::ProcessFigures process;
};

/// A run is "cold" only with two proofs: mincore before, and the bytes that the kernel says this
/// process made the disk read. Else it is "warm", or "memory" for a file system in memory. Pinned
/// by tests/bench/runs/bench_test.cpp.
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
               const RoundFloor& floor);

/// The file of records, one JSON object a line. Each line is on its way to the disk when append()
/// returns, so that an interruption loses at most the run that it interrupts.
class RecordFile {
 public:
  /// Reads the records that are there, and cuts off a last line without a newline. With an empty
  /// path records are only kept in memory. Errors: kIo; kInvalidArgument for a file with another
  /// line than a record, which is not touched.
  explicit RecordFile(std::filesystem::path path);
  void append(nlohmann::ordered_json record);
  const std::vector<nlohmann::ordered_json>& records() const { return records_; }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
  std::vector<nlohmann::ordered_json> records_;
};

}  // namespace plait::bench
