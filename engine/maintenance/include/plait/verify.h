// plait/verify.h: reads everything that a store has committed and checks it, and repairs the
// damaged parts that can be made again.
//
// Makers (plait/extend/block_maker.h) make blocks and base records again from the base mesh, such
// as those of a subdivision. repair() writes a block or file only if the bytes are proven to be the
// lost ones: they have the checksum that the committed version records.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "plait/detail/namespace.h"
#include "plait/extend/backend_registry.h"
#include "plait/extend/block_maker.h"
#include "plait/progress.h"
#include "plait/store.h"

PLAIT_BEGIN_NAMESPACE

/// A block whose stored bytes have another checksum than its entry in the block table, or which
/// cannot be read.
struct DamagedBlock {
  std::string attribute;
  int level = 0;
  std::uint64_t block = 0;
  std::uint64_t file_offset = 0;
  EdgeId first_edge = 0, edge_after = 0;  ///< [first_edge, edge_after)
  std::string reason;
};

/// What verify() found.
struct VerifyReport {
  std::uint64_t blocks = 0, bytes = 0;  ///< checked; raw bytes
  std::uint64_t never_written = 0;      ///< of these, blocks that are zeros without being read
  std::vector<DamagedBlock> damaged;    ///< at most 1,000; see damaged_count
  std::uint64_t damaged_count = 0;
};

/// Reads every block of every level from its file, one after another. Damaged blocks, and blocks
/// that the operating system cannot read, go into the report. Errors: kCancelled, kOutOfMemory; kIo
/// if changed blocks cannot be written before. `progress` counts raw bytes. `damaged` is called for
/// every bad block; the report lists only the first ones. Damage that keeps a store from being
/// opened: see check_store() (plait/extend/check_store.h).
VerifyReport verify(const Store& store, const ProgressCallback& progress = {},
                    const std::function<void(const BlockAddress&)>& damaged = {});

/// Options of repair().
struct RepairOptions {
  bool dry_run = false;                     ///< reports what could be repaired, changes nothing
  std::uint64_t budget_bytes = 256u << 20;  ///< for blocks in memory
  ProgressCallback progress = {};  ///< counts of the phase; units differ from phase to phase
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
/// What is lost stays as it is. Without `makers` no block is made again. Nobody else may have the
/// store open; with `dry_run` others may read it. If the repair is cancelled or killed, some blocks
/// are repaired and the others are as before. Errors: those of check_store and Store::open for what
/// concerns the whole store; kBudget, kCancelled, kIo, kNoSpace.
RepairReport repair(const std::filesystem::path& path, const RepairOptions& options,
                    const BackendRegistry& backends,
                    const std::shared_ptr<const BlockMakers>& makers = library_block_makers());

PLAIT_END_NAMESPACE
