// The blocks of parts that are complete, read before a join takes them.
#pragma once

#include <vector>

#include "format/version_description.h"
#include "parts/done_file.h"
#include "parts/plan_file.h"
#include "plait/base_mesh.h"
#include "plait/detail/edge_shards.h"
#include "plait/extend/backend_registry.h"
#include "plait/extend/directory.h"
#include "plait/extend/level_geometry.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Reads the blocks of the levels that the parts of a plan make.
class PartBlocks {
 public:
  /// `description` is of the version that the parts make. What is given must outlive this object.
  PartBlocks(const PlanFile& plan, const BaseMesh& mesh, const VersionDescription& description,
             const EdgeShards& shards, const RegisteredBackend& backend);

  /// Reads all blocks of a part, whose directory is in `plan_directory`. Errors: kCorruption for a
  /// block or a table with another checksum; kIo.
  void read_all(const Directory& plan_directory, const DoneFile& part) const;

 private:
  bool is_made_by_parts(const AttributeRecord& attribute) const;

  const PlanFile& plan_;
  const BaseMesh& mesh_;
  const VersionDescription& description_;
  const RegisteredBackend& backend_;
  std::vector<LevelGeometry> levels_;  ///< of all attributes, in shards
};

PLAIT_END_NAMESPACE
