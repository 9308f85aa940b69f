#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/default_arithmetic.h"
#include "format/file_names.h"
#include "format/version_description.h"
#include "parts/link_or_copy.h"
#include "parts/plan_figures.h"
#include "parts/plan_file.h"
#include "plait/error.h"
#include "plait/extend/parts.h"
#include "plait/extend/provenance.h"
#include "store/new_output.h"
#include "store/recovery.h"
#include "store/stored_version.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

bool is_of_subdivision(const AttributeRecord& attribute) {
  return std::ranges::all_of(attribute.levels,
                             [](const LevelRecord& level) { return level.generation == 1; });
}

const AttributeRecord* find(const VersionDescription& description, std::string_view name) {
  const auto at = std::ranges::find(
      description.attributes, name,
      [](const AttributeRecord& attribute) -> std::string_view { return attribute.schema.name; });
  return at == description.attributes.end() ? nullptr : &*at;
}

/// All of the plan but its figures.
PlanFile plan_of(const StoredVersion& version, const std::filesystem::path& store) {
  const VersionDescription& at = version.description();
  const auto refuse = [&](ErrorCode code, const std::string& why) {
    throw Error(code, fmt::format("plan {} again: {}", store.native(), why));
  };
  if (at.shards.empty())
    refuse(ErrorCode::kNotSupported, "its levels are in one piece: plait repair mends them");
  const AttributeRecord* const position = find(at, "position");
  const AttributeRecord* const normal = find(at, "normal");
  const Provenance& made = at.provenance;
  if (position == nullptr || made.scheme.empty() || !is_of_subdivision(*position))
    refuse(ErrorCode::kNotSupported,
           "a pass has replaced the positions that its plan made, and no version with what the "
           "pass read is left");
  if (made.program != program_version())
    refuse(ErrorCode::kNotSupported,
           fmt::format("plait {} made its parts, and this is plait {}: all parts need the same",
                       made.program, program_version()));
  PlanFile file;
  PartsPlan& plan = file.plan;
  plan.uuid = version.manifest().uuid;
  plan.program = made.program;
  plan.levels = at.finest_level(*position);
  plan.base_level = made.base_level;
  plan.backend = at.backend;
  file.vertex_count = at.vertex_count;
  file.edge_count = at.edge_count;
  file.face_count = at.face_count;
  file.base_mesh = {at.base_mesh_bytes, at.base_mesh_checksum};
  file.block_bytes = at.block_bytes;
  file.shares_files = at.shares_files;
  file.scheme = made.scheme;
  file.layout = made.layout;
  file.limit = made.limit;
  file.precision = position->schema.type;
  // Parts make the attributes 0 and 1; a pass makes others.
  file.normals = normal != nullptr && normal->number == 1 && is_of_subdivision(*normal);
  if (plan.backend == "compressed") {
    file.position_pipeline = position->pipeline.to_text();
    if (file.normals) file.normal_pipeline = normal->pipeline.to_text();
  }
  return file;
}

}  // namespace

PartsPlan plan_again(const std::filesystem::path& store, const std::filesystem::path& path,
                     const BackendRegistry& backends,
                     const std::function<void()>& before_files) try {
  const DefaultArithmetic arithmetic;
  check_new_directory(path);
  const Directory directory = open_store_directory(store);
  const StoredVersion version(directory, open_for_reading(directory));
  PlanFile file = plan_of(version, store);
  const BaseMesh mesh = version.read_base_mesh();
  std::vector<EdgeId> starts;
  for (const ShardRecord& shard : version.description().shards) starts.push_back(shard.first_edge);
  add_figures(file, mesh, EdgesInMemory(mesh.topology()), starts);
  file.plan.vertices = counts_at_level(mesh, file.plan.levels - file.plan.base_level).vertices;
  if (before_files) before_files();
  make_new_directory(
      path, [&](const std::string& what) { file.plan.warnings.push_back(what); }, remove_plan,
      [&](const Directory& plan) {
        link_or_copy(directory, kBaseMeshName, plan);
        if (directory.contains(kBaseIndexName)) link_or_copy(directory, kBaseIndexName, plan);
        file.plan.memory = memory_of_parts(plan, file, OutputName(path).path, backends);
        write_plan_file(plan, file);
      });
  return file.plan;
} catch (const std::bad_alloc&) {
  throw out_of_memory("plan " + store.native() + " again");
}

PLAIT_END_NAMESPACE
