#include "subdivision_job/run.h"

#include <fmt/format.h>

#include <string>
#include <utility>

#include "plait/digest.h"
#include "plait/error.h"
#include "plait/left_overs.h"
#include "plait/recode_attribute.h"
#include "plait/stopwatch.h"
#include "subdivision_job/earlier_run.h"
#include "subdivision_job/planning.h"
#include "subdivision_job/run_size.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// Whether no block of the attribute takes a byte. Then there is nothing to encode. REQUIRES: all
/// blocks are written.
bool is_predicted(const Store& store, AttributeId id) {
  for (int level = store.base_level() + 1; level <= store.attributes()[id].finest_level; ++level)
    for (const BlockEntry& entry : store.level_file(id, level).table.entries())
      if (entry.encoding != BlockEncoding::kPredicted) return false;
  return true;
}

MeshFigures figures_of(const BaseMesh& mesh) {
  return {mesh.vertex_count(), mesh.edge_count(), mesh.face_count(), mesh.border_edge_count()};
}

}  // namespace

void PlannedRun::tell(SubdivisionStep step, std::string_view phase, std::uint64_t done,
                      std::uint64_t total) {
  if (watch_.progress && !watch_.progress({step, phase, done, total}))
    throw Error(ErrorCode::kCancelled, fmt::format("subdivide: cancelled, {}", phase));
}

BaseMesh PlannedRun::make_base(BaseMesh mesh) {
  Stopwatch clock;
  enter(SubdivisionStep::kBaseMesh);
  if (plan_.store.base_level > 0)
    mesh = request_.own_scheme ? rebase(mesh, plan_.store.base_level, *request_.own_scheme,
                                        plan_.precision == ComponentType::kFloat64)
                               : rebase(mesh, plan_.store.base_level, plan_.subdivide.scheme,
                                        plan_.precision == ComponentType::kFloat64);
  result_.import_seconds = plan_.import_seconds;
  result_.base = figures_of(mesh);
  result_.refine_seconds = clock.lap();

  enter(SubdivisionStep::kLayout);
  LaidOutMesh laid_out = lay_out(mesh, plan_.layout);
  result_.layout_seconds = clock.lap();
  result_.spans = laid_out.spans;
  plan_.store.layout = to_string(laid_out.kind);
  if (store_) check_same_mesh(*store_, laid_out.mesh, plan_);
  throw_refusal(plan_);
  return std::move(laid_out.mesh);
}

void PlannedRun::create_store(BaseMesh base) {
  const auto create = [&](const std::filesystem::path& path) {
    store_ = Store::create(path, std::move(base), plan_.store, backends_);
    add_base_positions(*store_, plan_.precision == ComponentType::kFloat64);
  };
  if (!plan_.keeps_store) return create({});
  if (plan_.commits_levels) return create(request_.store);
  output_.emplace(request_.store, request_.existing == ExistingStore::kReplace ? Existing::kReplace
                                                                               : Existing::kRefuse);
  remove_left_overs_of(request_.store, [&](const std::string& what) {
    if (watch_.warn) watch_.warn(what);
  });
  build_output(*output_, [&] { create(output_->make()); });
}

void PlannedRun::commit() {
  enter(SubdivisionStep::kCommit);
  const Stopwatch clock;
  store_->commit();
  result_.commit_seconds += clock.seconds();
}

void PlannedRun::open_store(BaseMesh base) {
  enter(SubdivisionStep::kLevels);
  const Stopwatch clock;
  if (!store_) create_store(std::move(base));
  result_.resumed_level = store_->finest_level();
  result_.base_mesh_bytes =
      store_->base().memory_bytes() + subdivide_resident_bytes(*store_, plan_.subdivide);
  result_.refine_seconds += clock.seconds();
}

void PlannedRun::encode_anew() {
  const BackendRegistry::Entry& backend = backends_.find(plan_.store.backend);
  if (!request_.pipeline_of || !backend.traits.compressed) return;
  store_->pager().flush();
  for (AttributeId id = 0; id < store_->attributes().size(); ++id) {
    const AttributeSchema schema = store_->attributes()[id].schema;
    const std::string pipeline = request_.pipeline_of(schema);
    if (!backend.needs_other_blocks(pipeline, schema) || is_predicted(*store_, id)) continue;
    enter(SubdivisionStep::kEncode);
    recode_attribute(*store_, id, pipeline, [&](std::uint64_t done, std::uint64_t total) {
      tell(SubdivisionStep::kEncode, schema.name, done, total);
      return true;
    });
  }
}

void PlannedRun::make_levels() {
  const Stopwatch clock;
  Store& store = *store_;
  if (!plan_.earlier || !plan_.earlier->finished) {
    if (!request_.ignore_size) check_budget(plan_, store);
    throw_refusal(plan_);
    // Normals fit only the level that they were computed for. So a store with normals gets the new
    // levels and the new normals in one commit.
    const bool by_levels = plan_.commits_levels && !store.has_attribute("normal");
    if (!plan_.earlier && by_levels) commit();
    SubdivideOptions options = plan_.subdivide;
    if (by_levels) options.level_done = [&](int) { commit(); };
    options.proceed = [&](const SubdivideProgress& now) {
      tell(SubdivisionStep::kLevels, now.phase, now.vertices_done, now.vertices_total);
      return true;
    };
    subdivide(store, options);
    encode_anew();
    commit();
  }
  result_.refine_seconds += clock.seconds() - result_.commit_seconds;
  for (AttributeId id = 0; id < store.attributes().size(); ++id)
    if (const int finest = store.attributes()[id].finest_level; finest > store.base_level())
      result_.pipelines[store.attributes()[id].schema.name] = store.level_file(id, finest).pipeline;
  result_.paging = store.statistics();
  result_.stored_bytes = store.stored_bytes();
  for (const AttributeInfo& attribute : store.attributes())
    result_.base_mesh_bytes += store.base().vertex_count() * attribute.schema.record_bytes();
}

void PlannedRun::read_back() {
  if (!request_.digest) return;
  enter(SubdivisionStep::kDigest);
  const Stopwatch clock;
  DigestOptions options;
  options.threads = request_.threads;
  options.proceed = [&](std::uint64_t done, std::uint64_t total) {
    tell(SubdivisionStep::kDigest, "", done, total);
    return true;
  };
  result_.digest = digest(*store_, options).to_string();
  result_.digest_seconds = clock.seconds();
}

void PlannedRun::publish() {
  if (!plan_.keeps_store) {
    result_.in_memory = std::move(store_);
    return;
  }
  enter(SubdivisionStep::kPublish);
  result_.store = output_ ? output_->final_path() : store_->path();
  store_->close();
  if (output_) output_->publish(plan_.store.durability == Durability::kCommit, watch_.warn);
}

PLAIT_END_NAMESPACE
