// Damaged blocks of a store that opens.
#pragma once

#include <string>
#include <vector>

#include "maintenance/block_proof.h"
#include "maintenance/recomputed_store.h"
#include "plait/store.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

class BlockRepair {
 public:
  /// `damaged` is in the order of verify. The arguments outlive this object.
  BlockRepair(Store& store, const std::vector<BlockAddress>& damaged, const RepairOptions& options,
              RecomputedStore& recomputed, BlockProof& proof)
      : store_(store),
        damaged_(damaged),
        options_(options),
        recomputed_(recomputed),
        proof_(proof),
        rebuilt_(damaged.size()) {}

  /// Writes what is proven into the store, and leaves the commit to the caller; with
  /// options.dry_run only says what it would write.
  void run();
  /// Of each damaged block, whether run() found its content.
  const std::vector<bool>& rebuilt() const { return rebuilt_; }
  /// Why a block that is not rebuilt cannot be.
  std::string why_lost(const BlockAddress& block) const;

 private:
  const std::string& name(AttributeId attribute) const {
    return store_.attributes()[attribute].schema.name;
  }
  const AttributeSchema& schema(AttributeId attribute) const {
    return store_.attributes()[attribute].schema;
  }
  bool is_open(std::size_t at) const {
    return !rebuilt_[at] && !needs_other_blocks(damaged_[at]) &&
           recomputed_.refusal(name(damaged_[at].attribute)).empty();
  }
  /// Such a block cannot be proven alone, and blocks that others are encoded from cannot change.
  bool needs_other_blocks(const BlockAddress& block) const;
  PinnedBlock made_block(Store& made, const BlockAddress& at) const;
  void progress(const char* phase, std::uint64_t done, std::uint64_t total) const;
  std::vector<std::size_t> proven_by_seals(Store& made);
  /// Where the codec at hand does not compress as the one did that wrote the store, seals prove
  /// nothing: then all that is whole of the attribute must be what was computed anew.
  std::vector<std::size_t> proven_by_surroundings(Store& made);
  /// Levels in which the codec compresses differently, or none if anything of the attribute
  /// differs.
  std::vector<int> levels_of_another_codec(Store& made, AttributeId attribute);
  void write(Store& made, const std::vector<std::size_t>& proven);

  Store& store_;
  const std::vector<BlockAddress>& damaged_;
  const RepairOptions& options_;
  RecomputedStore& recomputed_;
  BlockProof& proof_;
  std::vector<bool> rebuilt_;
};

PLAIT_END_NAMESPACE
