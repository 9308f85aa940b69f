// bench/backends/cell.h: a cell of the table of `plait bench`: one measurement, which every round
// repeats.
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

namespace plait::bench {

/// docs/bench.md explains the members.
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
  double rate = 0;       ///< of an open loop; 0 for none
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

}  // namespace plait::bench
