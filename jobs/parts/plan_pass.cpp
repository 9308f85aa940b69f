#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "base/default_arithmetic.h"
#include "format/manifest.h"
#include "io/machine.h"
#include "parts/cuts.h"
#include "parts/pass_result.h"
#include "parts/plan_file.h"
#include "passes/surface_passes.h"
#include "plait/error.h"
#include "plait/extend/parts.h"
#include "plait/extend/provenance.h"
#include "plait/extend/store_access.h"
#include "store/new_output.h"
#include "store/recovery.h"
#include "store/stored_version.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// The result's pipelines are those of another attribute, whose records may have another type.
void check_result_pipelines(const AttributeRecord& made, const RegisteredBackend& backend) {
  backend.check_pipelines(made.pipeline, made.schema);
  if (backend.needs_other_blocks(made.pipeline, made.schema))
    throw Error(ErrorCode::kNotSupported,
                fmt::format("plan pass: pipeline {} encodes blocks of '{}' with the help of other "
                            "blocks, and a part has only its own",
                            made.pipeline.to_text(), made.schema.name));
}

/// All of the plan but the cuts, from the version that the store has.
PlanFile plan_of_version(const StoredVersion& version, const PassRequest& request,
                         const BackendRegistry& backends) {
  const VersionDescription& at = version.description();
  if (at.shards.empty())
    throw Error(ErrorCode::kNotSupported,
                fmt::format("plan pass over {}: its levels are in one piece; passes in parts work "
                            "on stores that plait join has made without --concat",
                            request.store.native()));
  if (version.manifest().sequence + 1 > kMaxSequence)
    throw Error(ErrorCode::kNotSupported, "plan pass: the store has its last version");
  PlanFile file;
  PartsPlan& plan = file.plan;
  plan.uuid = version.manifest().uuid;
  plan.program = program_version();
  plan.backend = at.backend;
  plan.base_level = at.provenance.base_level;
  file.vertex_count = at.vertex_count;
  file.edge_count = at.edge_count;
  file.face_count = at.face_count;
  file.base_mesh = {at.base_mesh_bytes, at.base_mesh_checksum};
  file.block_bytes = at.block_bytes;
  file.shares_files = at.shares_files;
  file.layout = at.provenance.layout;
  PlannedPass& planned = plan.pass.emplace();
  planned.store = absolute_path(request.store).lexically_normal();
  planned.version = version.manifest().sequence;
  planned.version_checksum = version.manifest().version_checksum;
  planned.pass = request.pass;
  planned.pass.kernel = {};
  const VersionDescription next = version_after(at, request.pass, file.version(), plan.program);
  file.of_pass.attribute_number = at.next_attribute_number;
  for (const AttributeRecord& attribute : next.attributes) {
    file.of_pass.level_count += static_cast<std::uint32_t>(attribute.levels.size());
    if (attribute.number != file.of_pass.attribute_number) continue;
    check_result_pipelines(attribute, backends.find(at.backend));
    planned.result = attribute.schema;
    plan.levels = next.finest_level(attribute);
  }
  if (plan.levels <= plan.base_level)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("plan pass over {}: expected levels over the base mesh, found none",
                            request.store.native()));
  const std::uint64_t files = file.shares_files ? next.attributes.size() : file.of_pass.level_count;
  plan.files =
      at.shards.size() * (files + 1) + next.attributes.size() + next.face_attributes.size() + 4;
  return file;
}

}  // namespace

PartsPlan plan_pass(const PassRequest& request, const BackendRegistry& backends) try {
  const DefaultArithmetic arithmetic;
  check_pass(request.pass);
  if (request.pass.name == "fractal" || request.pass.remakes_normals)
    throw Error(ErrorCode::kNotSupported,
                fmt::format("plan pass '{}': a pass in parts makes one attribute, and no fractal: "
                            "plait pass makes it in one process",
                            request.pass.name));
  check_new_directory(request.plan);
  PlanFile file;
  PartsPlan& plan = file.plan;
  OpenOptions open;
  open.budget_bytes = request.budget_bytes;
  Store store = Store::open(request.store, open, backends);
  StoreAccess::refuse_depths(store, "plan a pass over", store.finest_level());
  {
    const Directory directory = open_store_directory(request.store);
    const StoredVersion version(directory, open_for_reading(directory));
    file = plan_of_version(version, request, backends);
    if (plan.pass->version != store.sequence())
      throw Error(ErrorCode::kBusy, fmt::format("plan pass over {}: another process changes it",
                                                request.store.native()));
    std::vector<EdgeId> starts;
    for (const ShardRecord& shard : version.description().shards)
      starts.push_back(shard.first_edge);
    PartCost cost;
    cost.levels = plan.levels - plan.base_level;
    cost.ns_per_record = kNsPerByte * static_cast<double>(plan.pass->result.record_bytes());
    cost.ns_per_point = kNsPerPoint;
    plan.parts = figures_of_parts(EdgesInMemory(store.base().topology()), starts, cost);
    for (PlannedPart& part : plan.parts)
      part.bytes = part.records * plan.pass->result.record_bytes();
  }
  plan.vertices = counts_at_level(store.base(), plan.levels - plan.base_level).vertices;
  if (Pass& pass = plan.pass->pass; pass.name == "noise" && !pass.diagonal) {
    VisitOptions visit;
    visit.name = "bounding box";
    visit.threads = request.threads;
    visit.progress = request.progress;
    pass.diagonal = box_of_positions(store, visit).diagonal();
  }
  store.close();

  if (request.before_files) request.before_files();
  make_new_directory(
      request.plan, [&](const std::string& what) { plan.warnings.push_back(what); }, remove_plan,
      [&](const Directory& directory) { write_plan_file(directory, file); });
  return plan;
} catch (const std::bad_alloc&) {
  throw out_of_memory("plan pass");
}

PLAIT_END_NAMESPACE
