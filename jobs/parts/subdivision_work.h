// A plan of a subdivision: how its parts are made (subdivision_work.cpp) and joined
// (subdivision_join.cpp).
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "format/version_description.h"
#include "parts/part_blocks.h"
#include "parts/part_work.h"
#include "plait/base_mesh.h"
#include "plait/extend/file.h"
#include "plait/subdivide.h"
#include "store/unpublished_store.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

class SubdivisionWork : public PartWork {
 public:
  SubdivisionWork(const Directory& plan_directory, const PlanFile& plan)
      : PartWork(plan_directory, plan) {}

  ComputedPart compute(std::uint32_t part, const Directory& directory, const PartOptions& options,
                       const BackendRegistry& backends) const override;
  Needs needs(std::uint32_t part, const Directory& directory,
              const BackendRegistry& backends) const override;
  void check(const JoinCall& call) override;
  bool is_joined() const override { return is_joined_; }
  bool needs_all_parts() const override { return !is_joined_; }
  std::unique_ptr<PartBlocks> blocks(const JoinCall& call,
                                     const std::vector<DoneFile>& parts) override;
  void commit(const JoinCall& call, const std::vector<DoneFile>& parts, const std::string& digest,
              const std::function<void(std::size_t)>& tell) override;

 private:
  EdgeShards shards() const { return {plan_.starts(), plan_.edge_count}; }
  VersionDescription description_of(const std::vector<DoneFile>& parts) const {
    return decode_description(parts.front().description, 1, directory_.path());
  }
  File open_base() const;
  BaseMesh read_mesh(const File& file) const;
  BaseMesh mesh_of_part(std::uint32_t part) const;
  Store create_store(std::uint32_t part, const Directory& directory, const BaseMesh& mesh,
                     const PartOptions& options, const BackendRegistry& backends) const;
  SubdivideOptions options_of(const PartOptions& options) const;
  void make_store(const std::filesystem::path& path, const std::vector<DoneFile>& parts,
                  const std::function<void(std::size_t)>& tell) const;
  void publish(const JoinCall& call, UnpublishedStore& output);
  StoreUuid uuid_of_result(const JoinOptions& options) const;
  bool is_store_of_plan(const std::filesystem::path& path, const StoreUuid& uuid) const;

  // For a join.
  bool is_joined_ = false;
  File base_;
  BaseMesh mesh_;
  VersionDescription description_;
  EdgeShards shards_;
};

PLAIT_END_NAMESPACE
