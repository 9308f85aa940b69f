// Repairs damaged blocks of a store that can be opened.
#pragma once

#include <optional>
#include <string>

#include "maintenance/block_proof.h"
#include "maintenance/made_again.h"
#include "plait/verify.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

class BlockRepair {
 public:
  /// The arguments outlive this object.
  BlockRepair(Store& store, const RepairOptions& options, MadeAgain& made, BlockProof& proof)
      : store_(store), options_(options), made_(made), proof_(proof) {
    made_.read_from(store);
  }

  /// Makes the block again, proves that it is the lost one, and writes it; with options.dry_run,
  /// does not write it. The caller commits. Returns why the block cannot be repaired, or nothing if
  /// it can.
  std::optional<std::string> why_lost(const BlockAddress& block);

 private:
  Store& store_;
  const RepairOptions& options_;
  MadeAgain& made_;
  BlockProof& proof_;
};

PLAIT_END_NAMESPACE
