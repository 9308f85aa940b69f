// The file `plan` of a plan, which never changes.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "format/base_mesh_file.h"
#include "plait/extend/directory.h"
#include "plait/extend/parts.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

inline constexpr char kPlanName[] = "plan";

/// What the version that a pass makes has.
struct PassVersion {
  std::uint32_t attribute_number = 0;  ///< of the result
  std::uint32_t level_count = 0;       ///< the levels of all attributes
};

/// All that the file says.
struct PlanFile {
  PartsPlan plan;
  std::uint64_t checksum = 0;  ///< of the file
  std::uint64_t vertex_count = 0, edge_count = 0, face_count = 0;
  StoredSize base_mesh;
  std::string scheme, layout;
  ComponentType precision = ComponentType::kFloat32;
  bool normals = false, limit = false;
  bool shares_files = false;  ///< a part has one file for all levels of an attribute
  std::uint64_t block_bytes = 0;
  std::string position_pipeline, normal_pipeline;  ///< empty: the backend's default
  PassVersion of_pass;                             ///< if plan.pass

  /// The version that the parts make.
  std::uint64_t version() const { return plan.pass ? plan.pass->version + 1 : 1; }
  std::vector<EdgeId> starts() const;
};

void write_plan_file(const Directory& directory, const PlanFile& plan);
/// Errors: kNotFound, kCorruption, kIo.
PlanFile read_plan_file(const Directory& directory);

/// Removes the files of a plan that is not finished.
void remove_plan(const Directory& directory);

/// Opens the directory of a plan. Errors: kNotFound if it is none.
Directory open_plan_directory(const std::filesystem::path& plan);

PLAIT_END_NAMESPACE
