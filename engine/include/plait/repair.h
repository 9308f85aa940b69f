// plait/repair.h: repairs the damaged parts of a store that can be computed again.
//
// Some attributes follow from the base mesh alone, such as positions and normals of a subdivision.
// The caller says how to compute them again (plait/kernels/recompute_subdivision.h for
// subdivisions), and repair() does so in a scratch store. It writes a block or file only if the
// bytes are proven to be the lost ones: they have the checksum that the committed version records.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "plait/check_store.h"
#include "plait/namespace.h"
#include "plait/store.h"
#include "plait/verify.h"

PLAIT_BEGIN_NAMESPACE

/// How to compute attributes of one store again from its base mesh.
struct Recomputation {
  /// Returns why make() does not make the attribute of this name, or an empty string if it does.
  std::function<std::string(std::string_view attribute)> refusal;
  /// The most raw bytes that the levels of `made` have while make() runs. repair() decides by them
  /// whether `made` is in memory or on the disk.
  std::uint64_t level_bytes = 0;
  /// Adds to `made` every attribute without a refusal, with the name, type, base records and levels
  /// that the damaged store has. `made` has no attribute yet; its base mesh, base level and block
  /// size are those of the damaged store. repair() calls it once, or never if none of these
  /// attributes is damaged. It may be empty if all attributes have a refusal. If `proceed` returns
  /// false, it throws kCancelled.
  std::function<void(Store& made, int threads,
                     const std::function<bool(std::uint64_t done, std::uint64_t total)>& proceed)>
      make;
};

/// Returns how to compute attributes again of the store that `check` describes. repair() calls it
/// only if the base mesh is undamaged. `check` lives until repair() ends.
using PlanRecomputation = std::function<Recomputation(const StoreCheck& check)>;

/// Options of repair().
struct RepairOptions {
  bool dry_run = false;  ///< finds, computes and proves, and changes nothing
  /// For blocks in memory: half of it for the store, half for what is computed anew, which goes to
  /// a directory beside the store if it does not fit.
  std::uint64_t budget_bytes = 256u << 20;
  int threads = 1;
  /// False cancels. Units differ from phase to phase.
  std::function<bool(std::string_view phase, std::uint64_t done, std::uint64_t total)> proceed = {};
};

/// A file that was damaged.
struct RepairedFile {
  std::string name;    ///< in the store's directory
  std::string reason;  ///< what is wrong with it; of a lost one also why it cannot be rebuilt
};

/// What repair() found and rebuilt.
struct RepairReport {
  std::uint64_t files = 0, blocks = 0, bytes = 0;  ///< examined
  std::vector<RepairedFile> rebuilt_files, lost_files;
  /// False where the store cannot be opened: nothing is known about its blocks.
  bool blocks_examined = false;
  std::uint64_t rebuilt_count = 0, lost_count = 0;
  /// Blocks, at most 1,000 each. `reason` says what is wrong, and of a lost one why it cannot be
  /// rebuilt.
  std::vector<DamagedBlock> rebuilt, lost;
  std::vector<std::string> left_over, notes;  ///< as in StoreCheck
  std::uint64_t version = 0;                  ///< the store's, after the repair

  /// Everything is there, or would be without `dry_run`.
  bool whole() const { return lost_count == 0 && lost_files.empty(); }
};

/// Examines the store at `path`, rebuilds what it can, commits, and reads the rebuilt blocks back.
/// What is lost stays as it is. With an empty `recompute` no attribute is computed again. Nobody
/// else may have the store open; with `dry_run` others may read it. Cancelled or ended at any
/// instant, the store has what it had, or a part of the repair. Errors: those of check_store and
/// Store::open for what concerns the whole store; kBudget, kCancelled, kIo, kNoSpace;
/// kInvalidArgument if the recomputation makes other attributes than it says; those of the
/// recomputation.
RepairReport repair(const std::filesystem::path& path, const RepairOptions& options,
                    const BackendRegistry& backends, const PlanRecomputation& recompute);

PLAIT_END_NAMESPACE
