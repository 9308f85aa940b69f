// bench/runs/plan.h: which cells a command line asks for, what they cost, and how much a quick
// comparison moves, so that its time is enough on these disks.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "instrument/disk.h"
#include "plait/extend/backend_registry.h"
#include "runs/record.h"

namespace plait::bench {

/// A directory on a disk that is measured.
struct DiskPlace {
  std::filesystem::path directory;
  std::string name = {};  ///< of the disk; empty: what the system calls it
};

/// A mesh of the user's as the base mesh of what is measured.
struct MeshSubject {
  std::filesystem::path file;
  /// "spot.ply 1a2b3c4d5e6f7081": the file's name, and the checksum of positions and faces, so that
  /// records of different meshes never have the same key.
  std::string name;
  std::uint64_t base_vertices = 0;
  std::uint64_t vertices = 0;  ///< at the finest level
};

/// Reads the mesh in a process of its own, because reading uses threads and this process starts
/// others. With `chosen`, the levels are as many, up to `levels` and at least one, as take at most
/// `most_bytes`, and `chosen` gets their number. Errors: those of read_base_mesh().
MeshSubject mesh_subject(const std::filesystem::path& file, int levels,
                         std::uint64_t most_bytes = ~std::uint64_t{0}, int* chosen = nullptr);

struct PlanRequest {
  std::vector<DiskPlace> disks = {{"."}};
  std::vector<std::string> backends = {"all"}, workloads = {"all"};
  std::optional<MeshSubject> mesh;  ///< its levels are those of `levels`
  std::uint64_t vertices = 0;       ///< of a torus as base mesh; 0: from the sizes
  int levels = 4;
  std::vector<std::uint64_t> memory = {256u << 20};
  /// Empty: the default of each backend, or less if the budget has no room for 16 such blocks.
  std::vector<std::uint64_t> blocks;
  std::vector<double> sizes = {0.5, 3};  ///< bytes of the levels over memory
  std::vector<int> threads = {1};
  int rounds = 5;  ///< for the estimate of minutes
};

struct PlannedDisk {
  instrument::DiskFacts facts;
  std::string name;                ///< that no other disk of the plan has
  std::uint64_t needed_bytes = 0;  ///< stores, floors and a copy of the largest store, together
};

struct Plan {
  std::vector<Cell> cells;
  std::vector<PlannedDisk> disks;
  std::vector<std::string> left_out;  ///< lines: what was asked for and why it is not here
  std::vector<std::string> chosen;    ///< lines: which backend `auto` is in which cells, and why
  double minutes = 0;                 ///< a guess: see add_costs() in plan.cpp
};

/// "all" of the backends are those that keep files, and "auto" is what choose_backend() chooses for
/// the disk, the size and the memory limit. A backend that compresses gets the presets
/// `fast` and `default`. Each cell is there once. Errors: kInvalidArgument, kNotFound,
/// kNotSupported for names and values.
Plan make_plan(const PlanRequest& request, const BackendRegistry& backends);

/// Why the plan cannot run: a line for each disk that it would fill beyond nine tenths, or beyond
/// `limit_bytes` unless that is 0. Empty: it can.
std::vector<std::string> refusals(const Plan& plan, std::uint64_t limit_bytes);

/// Cells, bytes, space and minutes, for a dry run.
std::string to_text(const Plan& plan);

/// Bytes a second of one stream, to the disk and from it.
struct DiskSpeed {
  double write = 0, read = 0;
};

/// The memory limit with which `plait bench --quick` measures on all of `disks`: the largest of 64,
/// 32 and 16 MiB with which four rounds, and the making of the stores before them, are likely to
/// take at most `seconds`. 16 MiB if none is. Pinned by QuickMemory_* in
/// tests/bench/runs/bench_test.cpp.
std::uint64_t quick_memory(std::span<const DiskSpeed> disks, double seconds);

/// Moves 32 MiB each way in each directory, in processes of their own, and removes its files.
/// Errors: kNotFound, kIo, kNoSpace.
std::vector<DiskSpeed> measure_speeds(std::span<const std::filesystem::path> directories);

}  // namespace plait::bench
