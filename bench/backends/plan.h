// bench/backends/plan.h: which cells a command line asks for, and what they cost.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "backends/cell.h"
#include "backends/mesh_subject.h"
#include "instrument/disk.h"
#include "plait/extend/backend_registry.h"

namespace plait::bench {

/// A directory on a disk that is measured.
struct DiskPlace {
  std::filesystem::path directory;
  std::string name = {};  ///< of the disk; empty: what the system calls it
};

struct PlanRequest {
  std::vector<DiskPlace> disks = {{"."}};
  std::vector<std::string> backends = {"all"}, workloads = {"all"};
  std::vector<std::string> codecs = {"fast", "default"};  ///< presets or pipelines
  std::optional<MeshSubject> mesh;                        ///< its levels are those of `levels`
  std::uint64_t vertices = 0;  ///< of a torus as base mesh; 0: from the sizes
  int levels = 4;
  std::vector<std::uint64_t> memory = {256u << 20};
  /// Empty: for each memory 1 MiB, or less if the budget has no room for 16 such blocks.
  std::vector<std::uint64_t> blocks;
  std::vector<double> sizes = {0.5, 3};  ///< bytes of the levels over memory
  std::vector<int> threads = {1};
  double rate = 0;
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
/// the disk, the size and the memory limit. A backend that needs a pipeline gets each of
/// `codecs`. Each cell is there once. Errors: kInvalidArgument, kNotFound, kNotSupported for
/// names and values.
Plan make_plan(const PlanRequest& request, const BackendRegistry& backends);

/// Why the plan cannot run: a line for each disk that it would fill beyond nine tenths, or beyond
/// `limit_bytes` unless that is 0. Empty: it can.
std::vector<std::string> refusals(const Plan& plan, std::uint64_t limit_bytes);

/// Cells, bytes, space and minutes, for a dry run.
std::string to_text(const Plan& plan);

}  // namespace plait::bench
