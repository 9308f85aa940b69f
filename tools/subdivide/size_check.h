// tools/subdivide/size_check.h: whether the machine has what a run needs, asked before the run
// begins. Every refusal names what is needed and what is there.
#pragma once

#include <cstdint>

#include "plait/base_mesh.h"
#include "plait/store.h"
#include "subdivide/plan.h"

namespace plait {

/// Estimates from the counts of the mesh, before it is refined in memory.
struct RunSize {
  std::uint64_t level_bytes = 0;  ///< all levels of all attributes when done, uncompressed
  std::uint64_t disk_bytes = 0;   ///< what the run adds to the disk at its widest, at most
  std::uint64_t longest_file_bytes = 0;
  std::uint64_t base_mesh_bytes = 0;  ///< of memory, while the base mesh is made and laid out
};
/// `base_level`: how often `input` will be refined in memory. `earlier`: the store that the run
/// goes on from, or nullptr.
RunSize size_of_run(const BaseMesh& input, int base_level, const SubdivisionPlan& plan,
                    const Store* earlier);

/// Memory for the base mesh, for levels kept in memory, and for what of the budget the run can
/// fill. Errors: kOutOfMemory.
void require_memory(const RunSize& size, const SubdivisionPlan& plan, BackendTraits backend);
/// Free space and the longest file there may be. What a backend compresses is counted at a quarter:
/// an estimate that lets through what has a chance. Errors: kNoSpace, kIo.
void require_disk(const RunSize& size, const std::filesystem::path& path, BackendTraits backend);
/// Frames of the widest pass, for executors that would find out at the finest level only.
/// Errors: kBudget.
void require_budget(const Store& store, const SubdivideOptions& subdivision);

}  // namespace plait
