// The next version of a store in shards, of the parts of a pass.
#pragma once

#include <filesystem>
#include <functional>
#include <vector>

#include "format/version_description.h"
#include "parts/done_file.h"
#include "parts/part_blocks.h"
#include "parts/plan_file.h"
#include "plait/base_mesh.h"
#include "plait/detail/edge_shards.h"
#include "plait/extend/backend_registry.h"
#include "plait/extend/directory.h"
#include "plait/extend/parts.h"
#include "store/lock.h"
#include "store/stored_version.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Holds the lock of the store that a pass changes.
class PassTarget {
 public:
  /// `plan` and `path`, that of the plan, must outlive this object. Errors: those of
  /// lock_for_writing(); kBadState for another store and another version than the plan's or the one
  /// after it; kCorruption for a plan that does not fit the store.
  PassTarget(const std::filesystem::path& store, const PlanFile& plan,
             const std::filesystem::path& path);

  /// What done files of the parts have as description.
  const std::vector<std::byte>& description_seal() const { return seal_; }
  /// The store has the version that the pass makes, or another one in its place.
  bool is_later() const { return version_.manifest().sequence == plan_.version(); }
  /// Whether these parts are the shards of the store's version. REQUIRES: is_later().
  bool is_made_of(const std::vector<DoneFile>& parts) const;

  /// The blocks that the parts make. This object must outlive them. Errors: as Store::open for the
  /// backend.
  PartBlocks blocks(const BackendRegistry& backends) const;
  /// Gives the files of the parts a name in the store, and commits. `tell` is called with the
  /// number of each part. Errors: kCorruption, kBusy, kIo, kNoSpace; those of `tell`.
  void commit(const Directory& plan_directory, const std::vector<DoneFile>& parts,
              const std::function<void(std::uint32_t)>& tell) const;

 private:
  const PlanFile& plan_;
  Directory store_;
  StoreLock lock_;
  StoredVersion version_;
  VersionDescription next_;
  std::vector<std::byte> seal_;
  BaseMesh mesh_;
  EdgeShards shards_;
};

PLAIT_END_NAMESPACE
