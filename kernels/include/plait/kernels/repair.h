// plait/kernels/repair.h: puts back what was damaged in a store, as far as it can be computed
// again.
//
// Positions (limit positions too) and normals of a refinement follow from the base mesh alone. They
// are computed anew in a scratch store, and a block or file is put back only if it is proven to be
// what was there: its bytes have the checksum that the committed version records for them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "plait/store.h"
#include "plait/verify.h"

namespace plait {

struct RepairOptions {
  bool dry_run = false;  ///< finds, computes and proves, and changes nothing
  /// For blocks in memory: half of it for the store, half for what is computed anew, which goes to
  /// a directory beside the store if it does not fit.
  std::uint64_t budget_bytes = 256u << 20;
  int threads = 1;
  /// False cancels. Units differ from phase to phase.
  std::function<bool(std::string_view phase, std::uint64_t done, std::uint64_t total)> proceed = {};
};

struct RepairedFile {
  std::string name;    ///< in the store's directory
  std::string reason;  ///< what is wrong with it; of a lost one also why it cannot be rebuilt
};

struct RepairReport {
  std::uint64_t files = 0, blocks = 0, bytes = 0;  ///< examined
  std::vector<RepairedFile> rebuilt_files, lost_files;
  /// False where the store cannot be opened: nothing is known about its blocks.
  bool blocks_examined = false;
  std::uint64_t rebuilt_count = 0, lost_count = 0;
  /// Blocks, at most 1,000 each. `reason` says what is wrong, and of a lost one why it cannot be
  /// rebuilt.
  std::vector<DamagedBlock> rebuilt, lost;
  std::vector<std::string> left_over, notes;  ///< as in StoreStructure
  std::uint64_t version = 0;                  ///< the store's, after the repair

  /// Everything is there, or would be without `dry_run`.
  bool whole() const { return lost_count == 0 && lost_files.empty(); }
};

/// Examines the store at `path`, rebuilds what it can, commits, and reads the rebuilt blocks back.
/// What is lost stays as it is. Nobody else may have the store open; with `dry_run` others may read
/// it. Cancelled or ended at any instant, the store has what it had, or a part of the repair.
/// Errors: those of check_structure and Store::open for what concerns the whole store; kBudget,
/// kCancelled, kIo, kNoSpace.
RepairReport repair(const std::filesystem::path& path, const RepairOptions& options,
                    const BackendRegistry& backends);

}  // namespace plait
