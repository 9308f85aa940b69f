#include "parts/subdivision_work.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "base/stopwatch.h"
#include "base/text.h"
#include "execution/part_digest.h"
#include "format/base_index_file.h"
#include "format/base_mesh_file.h"
#include "format/file_names.h"
#include "job_rules.h"
#include "parts/sealed_file.h"
#include "plait/error.h"
#include "plait/extend/store_access.h"
#include "plait/progress.h"
#include "schemes/table.h"
#include "store/parts/part_store.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// What the scratch memory of one thread leaves of the budget for blocks and further threads; all,
/// if blocks then do not fit.
std::uint64_t budget_beside_scratch(Store& store, SubdivideOptions options, std::uint64_t budget) {
  options.threads = 1;
  const Needs needs = plan_subdivision(store, options).needs();
  // A backend keeps up to a quarter of the budget for itself.
  const std::uint64_t frames = (4 * needs.frames + 2) / 3;
  return frames + needs.resident <= budget ? budget - needs.resident : budget;
}

}  // namespace

File SubdivisionWork::open_base() const {
  File base(directory_, kBaseMeshName, OpenMode::kRead);
  refuse_hole(base);
  return base;
}

BaseMesh SubdivisionWork::read_mesh(const File& file) const {
  if (directory_.contains(kBaseIndexName)) {
    refuse_hole(File(directory_, kBaseIndexName, OpenMode::kRead));
    const std::uint64_t border_edges = 2 * plan_.edge_count - 3 * plan_.face_count;
    if (auto mesh = open_base_index_file(
            directory_, {{plan_.vertex_count, plan_.edge_count, plan_.face_count, border_edges},
                         plan_.base_mesh.checksum,
                         "; remove the file: each part then computes the base mesh again"}))
      return *std::move(mesh);
  }
  BaseMesh mesh = read_base_mesh_file(file, plan_.base_mesh, plan_.vertex_count, plan_.face_count);
  if (mesh.edge_count() != plan_.edge_count)
    throw Error(ErrorCode::kCorruption,
                fmt::format("open {}: expected {} edges, found {}", file.path().native(),
                            plan_.edge_count, mesh.edge_count()));
  return mesh;
}

/// With the index of the base mesh, a part reads what it needs. Level 1 of a scheme of two rings is
/// made of the whole base mesh.
BaseMesh SubdivisionWork::mesh_of_part(std::uint32_t part) const {
  BaseMesh mesh = read_mesh(open_base());
  if (traits_of(scheme_from_name(plan_.scheme)).ring_count > 1) return mesh;
  return mesh.around(shards().first_edge(part), shards().edge_after(part));
}

Store SubdivisionWork::create_store(std::uint32_t part, const Directory& directory,
                                    const BaseMesh& mesh, const PartOptions& options,
                                    const BackendRegistry& backends) const {
  StoreOptions store;
  store.backend = plan_.plan.backend;
  store.block_bytes = plan_.block_bytes;
  store.budget_bytes = options.budget_bytes;
  store.parallel_for = options.parallel_for;
  if (!plan_.position_pipeline.empty())
    store.pipeline_of = [position = plan_.position_pipeline,
                         normal = plan_.normal_pipeline](const AttributeSchema& schema) {
      return LevelPipelines(schema.name == "normal" ? normal : position);
    };
  Store made =
      create_part_store(directory.path(), mesh, store, backends,
                        {.layout = plan_.layout, .base_level = plan_.plan.base_level},
                        {plan_.plan.uuid, shards(), part, plan_.base_mesh, plan_.shares_files});
  add_base_positions(made, plan_.precision);
  return made;
}

SubdivideOptions SubdivisionWork::options_of(const PartOptions& options) const {
  SubdivideOptions subdivision;
  subdivision.scheme = scheme_from_name(plan_.scheme);
  subdivision.levels = plan_.plan.levels;
  subdivision.normals = plan_.normals;
  subdivision.limit = plan_.limit;
  subdivision.executor = ExecutorKind::kFused;
  subdivision.threads = options.threads;
  subdivision.progress = options.progress;
  return subdivision;
}

Needs SubdivisionWork::needs(std::uint32_t part, const Directory& directory,
                             const BackendRegistry& backends) const {
  Store store = create_store(part, directory, mesh_of_part(part), {}, backends);
  return plan_subdivision(store, options_of({})).needs();
}

ComputedPart SubdivisionWork::compute(std::uint32_t part, const Directory& directory,
                                      const PartOptions& options,
                                      const BackendRegistry& backends) const {
  ComputedPart computed;
  const Stopwatch clock;
  const BaseMesh mesh = mesh_of_part(part);
  std::optional<Store> made(create_store(part, directory, mesh, options, backends));
  const SubdivideOptions subdivision = options_of(options);
  const std::uint64_t left = budget_beside_scratch(*made, subdivision, options.budget_bytes);
  if (left < options.budget_bytes) {
    PartOptions less = options;
    less.budget_bytes = left;
    made.reset();  // before the next one: both have the same directory
    made.emplace(create_store(part, directory, mesh, less, backends));
  }
  Store& store = *made;
  PlannedSubdivision planned = plan_subdivision(store, subdivision);
  warn_of_fewer_threads(fmt::format("part {}", part), planned.options().threads, options.threads,
                        options.budget_bytes, options.warn);
  if (options.warn && left == options.budget_bytes)
    if (const std::uint64_t over = planned.needs().resident; over > options.budget_bytes / 4)
      options.warn(fmt::format("part {}: {} of scratch memory come on top of the budget of {}",
                               part, format_bytes(over), format_bytes(options.budget_bytes)));
  computed.begin_seconds = clock.seconds();
  std::optional<FilledDigest> digest(store);
  planned.run();
  const double refined = clock.seconds();
  computed.content = finish_part_store(store);
  computed.description = encode_description(computed.content.description);
  const double written = clock.seconds();
  computed.digest = digest->with_base_vertices(*StoreAccess::own_vertices(store));
  digest.reset();  // before the store is closed
  store.close();
  computed.write_seconds = written - refined;
  computed.compute_seconds = clock.seconds() - computed.write_seconds - computed.begin_seconds;
  return computed;
}

std::unique_ptr<PartWork> PartWork::of(const Directory& plan_directory, const PlanFile& plan) {
  if (plan.plan.pass) return pass_work(plan_directory, plan);
  return std::make_unique<SubdivisionWork>(plan_directory, plan);
}

PLAIT_END_NAMESPACE
