#include "subdivision/run.h"

#include <fmt/format.h>

#include <string>
#include <utility>

#include "base/stopwatch.h"
#include "job_rules.h"
#include "plait/compression.h"
#include "plait/digest.h"
#include "plait/error.h"
#include "plait/extend/copy_levels.h"
#include "plait/extend/notices.h"
#include "plait/extend/recode_attribute.h"
#include "plait/extend/store_access.h"
#include "plait/store_info.h"
#include "prune/distance_depths.h"
#include "store/attribute_levels.h"
#include "subdivision/earlier_run.h"
#include "subdivision/planning.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

double step_of(const Store& store, AttributeId id, const ErrorBound& bound) {
  return Rounder(store.attributes()[id].schema, bound, store.base_bytes(id)).step();
}

MeshFigures figures_of(const BaseMesh& mesh) {
  return {mesh.vertex_count(), mesh.edge_count(), mesh.face_count(), mesh.border_edge_count()};
}

}  // namespace

bool PlannedRun::tell(const Progress& now) const {
  if (watch_.progress && !watch_.progress(now))
    throw Error(ErrorCode::kCancelled, fmt::format("subdivide: cancelled, {}", now.phase));
  return true;
}

void PlannedRun::enter(std::string_view step) {
  if (watch_.step) watch_.step(step);
  tell({step, 0, 1});
}

BaseMesh PlannedRun::make_base(BaseMesh mesh) {
  Stopwatch clock;
  enter("base mesh");
  if (plan_.base_level > 0)
    mesh = rebase(in_input_order(std::move(mesh)), plan_.base_level, plan_.subdivide.scheme,
                  plan_.precision);
  result_.import_seconds = plan_.import_seconds;
  result_.base = figures_of(mesh);
  result_.refine_seconds = clock.lap();

  enter("layout");
  LaidOutMesh ordered = laid_out(std::move(mesh), plan_.layout);
  result_.layout_seconds = clock.lap();
  result_.spans = ordered.spans;
  plan_.layout = ordered.kind;
  if (store_) check_same_mesh(*store_, ordered.mesh, plan_);
  throw_refusal(plan_);
  return std::move(ordered.mesh);
}

void PlannedRun::create_store(BaseMesh base) {
  StoreOptions options = plan_.store;
  if (request_.max_distance) options.durability = Durability::kNone;  // prune() makes another one
  const auto create = [&](const std::filesystem::path& path) {
    store_ = Store::create(
        path, std::move(base), options, backends_,
        {.layout = std::string(to_string(plan_.layout)), .base_level = plan_.base_level});
    add_base_positions(*store_, plan_.precision);
  };
  if (!plan_.keeps_store) return create({});
  if (plan_.commits_levels) return create(request_.store);
  std::optional<UnpublishedStore>& output = request_.max_distance ? all_levels_ : output_;
  output.emplace(request_.store, request_.existing, watch_.warn);
  build_output(*output, [&] { create(output->make()); });
}

void PlannedRun::commit() {
  enter("commit");
  const Stopwatch clock;
  store_->commit();
  result_.commit_seconds += clock.seconds();
}

void PlannedRun::open_store(BaseMesh base) {
  enter("levels");
  if (watch_.before_files) watch_.before_files();
  const Stopwatch clock;
  if (!store_) create_store(std::move(base));
  tell_notices(*store_, watch_.warn, request_.store);
  result_.resumed_level = store_->finest_level();
  result_.base_mesh_bytes = store_->base().memory_bytes();
  if (!plan_.earlier || !plan_.earlier->finished) plan_levels();
  result_.refine_seconds += clock.seconds();
}

void PlannedRun::plan_levels() {
  Store& store = *store_;
  // The levels that the store has were compared with the request; finer ones may have others.
  if (plan_.earlier && request_.pipeline_of)
    for (AttributeId id = 0; id < store.attributes().size(); ++id)
      store.set_pipeline(id, request_.pipeline_of(store.attributes()[id].schema));
  SubdivideOptions options = plan_.subdivide;
  // Normals fit only the level that they were computed for. So a store with normals gets the new
  // levels and the new normals in one commit.
  if (plan_.commits_levels && !store.has_attribute("normal"))
    options.level_done = [&](int) { commit(); };
  options.progress = [&](const Progress& now) { return tell(now); };
  levels_ = plan_subdivision(store, options);
  plan_.subdivide.threads = levels_->options().threads;
  if (levels_->options().executor != ExecutorKind::kTransparent)
    warn_of_fewer_threads("subdivide", plan_.subdivide.threads, request_.threads,
                          store.options().budget_bytes, watch_.warn);
  result_.base_mesh_bytes += levels_->needs().resident;
  try {
    levels_->check_budget();
  } catch (const Error& error) {
    refuse(plan_, "memory", error.code(), error.what());
    throw_refusal(plan_);
  }
}

void PlannedRun::encode() {
  const Provenance provenance = store_->provenance();
  for (const auto& [name, bound] : request_.max_errors.all()) {
    const AttributeId id = store_->attribute(name);
    enter("encode");
    RecodeOptions options;
    options.bound = bound;
    options.verify = request_.verify;
    options.progress = [&, &phase = name](const Progress& now) {
      return tell({phase, now.done, now.total});
    };
    recode_attribute(*store_, id,
                     pipeline_of_rounded(named_pipelines(*store_, id), step_of(*store_, id, bound)),
                     options);
    // Rounded positions have no scheme. But normals, which come later, are as the scheme made them.
    StoreAccess::set_provenance(*store_, provenance);
  }
  store_->finish_encoding([&, is_first = true](const Progress& now) mutable {
    if (std::exchange(is_first, false)) enter("encode");
    return tell(now);
  });
  if (!request_.max_errors.of("position")) return;
  Provenance rounded = provenance;
  rounded.scheme.clear();
  StoreAccess::set_provenance(*store_, rounded);
}

void PlannedRun::make_levels() {
  const Stopwatch clock;
  Store& store = *store_;
  if (levels_) {
    if (plan_.commits_levels && !plan_.earlier) commit();
    levels_->run();
    encode();
    commit();
  }
  result_.refine_seconds += clock.seconds() - result_.commit_seconds;
  result_.paging = store.info().paging;
  for (const AttributeInfo& attribute : store.attributes())
    if (plan_.piece_bytes == 0)
      result_.base_mesh_bytes += store.base().vertex_count() * attribute.schema.record_bytes();
  describe_levels();
}

void PlannedRun::describe_levels() {
  const Store& store = *store_;
  for (AttributeId id = 0; id < store.attributes().size(); ++id) {
    const auto& [schema, finest] = store.attributes()[id];
    if (finest > store.base_level())
      result_.pipelines[schema.name] = pipelines_of_levels(store, id).to_text();
    if (const auto& rounding = StoreAccess::rounding(store, id))
      result_.roundings[schema.name] = *rounding;
  }
  result_.stored_bytes = store.info().stored_bytes;
}

void PlannedRun::prune() {
  if (!request_.max_distance) return;
  const Stopwatch clock;
  store_->close();
  store_.reset();
  build_output(*all_levels_, [&] {
    OpenOptions open;
    open.budget_bytes = plan_.store.budget_bytes / 2;
    open.parallel_for = plan_.store.parallel_for;
    Store source = Store::open(all_levels_->path(), open, backends_);
    const double number = *request_.max_distance;
    const bool is_part = request_.distance_in_diagonals;
    DistanceDepths found = depths_by_distance(
        source, {.number = is_part ? 100 * number : number, .is_percent = is_part}, 1, watch_);
    result_.distance = found.distance;
    result_.faces_of_level.resize(static_cast<std::size_t>(request_.levels) + 1);
    for (const std::uint8_t depth : found.depths)
      ++result_.faces_of_level[static_cast<std::size_t>(plan_.base_level) + depth];
    StoreOptions options = plan_.store;
    options.budget_bytes = open.budget_bytes;
    output_.emplace(request_.store, request_.existing, watch_.warn);
    enter("copy");
    store_ = Store::create(output_->make(), source.base().with_depths(std::move(found.depths)),
                           options, backends_, source.provenance());
    copy_levels(source, *store_, [&](const Progress& now) { return tell(now); });
    commit();
    source.close();
  });
  all_levels_.reset();
  result_.drawn = counts_at_level(store_->base(), request_.levels - plan_.base_level);
  describe_levels();
  result_.prune_seconds = clock.seconds();
}

void PlannedRun::read_back() {
  if (!request_.digest) return;
  enter("digest");
  const Stopwatch clock;
  DigestOptions options;
  options.threads = request_.threads;
  options.progress = [&](const Progress& now) { return tell(now); };
  options.begins = [&](int threads) {
    warn_of_fewer_threads("digest", threads, request_.threads, store_->options().budget_bytes,
                          watch_.warn);
  };
  result_.digest = digest(*store_, options).to_string();
  result_.digest_seconds = clock.seconds();
}

void PlannedRun::publish() {
  if (!plan_.keeps_store) {
    result_.in_memory = std::move(store_);
    return;
  }
  enter("publish");
  result_.store = output_ ? output_->final_path() : store_->path();
  store_->close();
  if (output_) output_->publish(plan_.store.durability == Durability::kCommit);
}

PLAIT_END_NAMESPACE
