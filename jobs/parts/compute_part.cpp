#include "parts/compute_part.h"

#include <fmt/format.h>

#include <numeric>
#include <utility>
#include <vector>

#include "base/stopwatch.h"
#include "execution/part_digest.h"
#include "format/base_mesh_file.h"
#include "format/file_names.h"
#include "parts/sealed_file.h"
#include "plait/error.h"
#include "plait/extend/file.h"
#include "plait/subdivide.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

Store create_store(const Directory& plan_directory, const PlanFile& plan, std::uint32_t part,
                   const Directory& directory, const PartOptions& options,
                   const BackendRegistry& backends) {
  const File base(plan_directory, kBaseMeshName, OpenMode::kRead);
  refuse_hole(base);
  BaseMesh mesh = read_base_mesh_file(base, plan.base_mesh, plan.vertex_count, plan.face_count);
  if (mesh.edge_count() != plan.edge_count)
    throw Error(ErrorCode::kCorruption, fmt::format("open {}: expected {} edges, found {}",
                                                    plan_directory.path_of(kBaseMeshName).native(),
                                                    plan.edge_count, mesh.edge_count()));
  StoreOptions store;
  store.backend = plan.plan.backend;
  store.block_bytes = plan.block_bytes;
  store.budget_bytes = options.budget_bytes;
  if (!plan.position_pipeline.empty())
    store.pipeline_of = [position = plan.position_pipeline,
                         normal = plan.normal_pipeline](const AttributeSchema& schema) {
      return LevelPipelines(schema.name == "normal" ? normal : position);
    };
  PartOfStore of{plan.plan.uuid, EdgeShards(plan.starts(), plan.edge_count), part, plan.base_mesh};
  return create_part_store(directory.path(), std::move(mesh), store, backends,
                           {.layout = plan.layout, .base_level = plan.plan.base_level},
                           std::move(of));
}

}  // namespace

ComputedPart compute_part(const Directory& plan_directory, const PlanFile& plan, std::uint32_t part,
                          const Directory& directory, const PartOptions& options,
                          const BackendRegistry& backends) {
  ComputedPart computed;
  const Stopwatch clock;
  Store store = create_store(plan_directory, plan, part, directory, options, backends);
  add_base_positions(store, plan.precision);
  computed.begin_seconds = clock.seconds();
  SubdivideOptions subdivision;
  subdivision.scheme = scheme_from_name(plan.scheme);
  subdivision.levels = plan.plan.levels;
  subdivision.normals = plan.normals;
  subdivision.limit = plan.limit;
  subdivision.executor = ExecutorKind::kFused;
  subdivision.threads = options.threads;
  subdivision.progress = options.progress;
  subdivide(store, subdivision);
  const double refined = clock.seconds();
  computed.content = finish_part_store(store);
  const double written = clock.seconds();
  std::vector<AttributeId> all(store.attributes().size());
  std::iota(all.begin(), all.end(), 0);
  computed.digest = digest_of_part(
      store,
      owned_vertices(store.base().topology(), EdgeShards(plan.starts(), plan.edge_count), part),
      all, options.progress);
  store.close();
  computed.write_seconds = written - refined;
  computed.compute_seconds = clock.seconds() - computed.write_seconds - computed.begin_seconds;
  return computed;
}

PLAIT_END_NAMESPACE
