// What the parts of a plan make: a new store, by subdivision, or the next version of a store in
// shards, by a pass.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "parts/done_file.h"
#include "parts/part_blocks.h"
#include "parts/plan_file.h"
#include "plait/digest.h"
#include "plait/extend/backend_registry.h"
#include "plait/extend/directory.h"
#include "plait/extend/parts.h"
#include "plait/needs.h"
#include "store/parts/part_store.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

struct ComputedPart {
  PartContent content;
  std::vector<std::byte> description;  ///< DoneFile::description
  Digest digest;
  double begin_seconds = 0;    ///< to read the base mesh and to create the levels
  double compute_seconds = 0;  ///< to refine, and to compute the digest
  double write_seconds = 0;    ///< to write what was in memory, and to sync
};

/// What join_parts() got.
struct JoinCall {
  const std::filesystem::path& plan;
  const std::filesystem::path& store;
  const JoinOptions& options;
  const BackendRegistry& backends;
};

class PartWork {
 public:
  /// The plan and its directory must outlive the work.
  static std::unique_ptr<PartWork> of(const Directory& plan_directory, const PlanFile& plan);
  virtual ~PartWork() = default;

  /// Makes the files of the part's levels in `directory`, which is empty, and syncs them. Errors:
  /// as make_part().
  virtual ComputedPart compute(std::uint32_t part, const Directory& directory,
                               const PartOptions& options,
                               const BackendRegistry& backends) const = 0;

  /// The memory that one thread needs for compute(), as PlannedSubdivision::needs(). `directory` is
  /// empty, and stays so. Nothing is known of passes.
  virtual Needs needs(std::uint32_t, const Directory&, const BackendRegistry&) const { return {}; }

  // A join, step by step. Errors: those of join_parts().

  /// Whether the parts can become `call.store`. Holds the lock of a store that they change.
  virtual void check(const JoinCall& call) = 0;
  /// Whether check() found that `call.store` has what the parts make: a join that ran before.
  virtual bool is_joined() const = 0;
  /// Whether commit() needs all parts.
  virtual bool needs_all_parts() const { return true; }
  /// What the done files of all parts have as description; empty: they only have the same one.
  virtual std::span<const std::byte> description() const { return {}; }
  /// The blocks that the parts make. The work must outlive them. REQUIRES: at least one part; for a
  /// pass, !is_joined().
  virtual std::unique_ptr<PartBlocks> blocks(const JoinCall& call,
                                             const std::vector<DoneFile>& parts) = 0;
  /// Makes the store of all parts, which add up to `digest`. `tell` is called with the number of
  /// parts that were begun.
  virtual void commit(const JoinCall& call, const std::vector<DoneFile>& parts,
                      const std::string& digest, const std::function<void(std::size_t)>& tell) = 0;

 protected:
  PartWork(const Directory& plan_directory, const PlanFile& plan)
      : directory_(plan_directory), plan_(plan) {}

  const Directory& directory_;
  const PlanFile& plan_;
};

std::unique_ptr<PartWork> pass_work(const Directory& plan_directory, const PlanFile& plan);

PLAIT_END_NAMESPACE
