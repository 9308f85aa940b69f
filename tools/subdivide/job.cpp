#include "subdivide/job.h"

#include <utility>
#include <vector>

#include "final_name.h"
#include "measure.h"
#include "pipeline_flags.h"
#include "plait/backends/choose_backend.h"
#include "plait/error.h"
#include "plait/machine.h"
#include "plait/mesh_io.h"
#include "subdivide/resume.h"
#include "subdivide/size_check.h"

namespace plait {

SubdivisionJob::SubdivisionJob(SubdivisionRequest request, const BackendRegistry& backends,
                               SubdivisionEvents events)
    : request_(std::move(request)),
      backends_(backends),
      events_(std::move(events)),
      plan_(make_plan(request_, backends)) {
  if (!plan_.keeps_store && !request_.store.empty())
    events_.warning("backend " + plan_.store.backend +
                    " keeps nothing: " + request_.store.native() + " is not made");
  claim_name();
  store_ = open_earlier_run(request_, backends, plan_);
  if (!store_) require_compression(request_, backends);
}

void SubdivisionJob::claim_name() {
  if (!plan_.keeps_store || plan_.commits_levels) return;
  output_.emplace(request_.store, request_.force ? Existing::kReplace : Existing::kRefuse);
}

/// Where nobody asked for a backend the size of the store decides.
void SubdivisionJob::choose_backend(const BaseMesh& input) {
  const RunSize size =
      size_of_run(input, plan_.store.base_level, plan_, store_ ? &*store_ : nullptr);
  if (plan_.store.backend == kAutomaticBackend) {
    BackendChoice choice = plait::choose_backend(backends_, request_.store, size.level_bytes);
    plan_.store.backend = std::move(choice.name);
    plan_.backend_reason = std::move(choice.reason);
  }
  if (request_.ignore_size) return;
  const BackendTraits traits = backends_.find(plan_.store.backend).traits;
  require_memory(size, plan_, traits);
  require_disk(size, request_.store, traits);
}

void SubdivisionJob::prepare() {
  Stopwatch clock;
  std::vector<std::string> warnings;
  BaseMesh mesh = read_base_mesh(request_.mesh, &warnings);
  report_.import_seconds = clock.lap();
  for (const std::string& warning : warnings) events_.warning(warning);

  report_.input = figures_of(mesh);
  for (int level = 0; level <= request_.levels; ++level)
    report_.level_counts.push_back(counts_at_level(mesh, level));
  if (!store_)
    plan_.store.base_level =
        rebase_levels(request_.levels, plan_.double_precision ? 24 : 12, plan_.max_slot_bytes);
  choose_backend(mesh);
  if (plan_.store.base_level > 0)
    mesh = rebase(mesh, plan_.store.base_level, plan_.subdivide.scheme, plan_.double_precision);
  report_.refine_seconds = clock.lap();

  base_ = lay_out(mesh, plan_.layout);
  report_.layout_seconds = clock.lap();
  report_.base = figures_of(base_.mesh);
  report_.spans = base_.spans;
  plan_.store.layout = to_string(base_.kind);
  if (store_) require_same_mesh(*store_, base_.mesh);
}

Store SubdivisionJob::create_store(BaseMesh base) {
  if (!output_)
    return Store::create(plan_.keeps_store ? request_.store : std::filesystem::path(),
                         std::move(base), plan_.store, backends_);
  return build_output(*output_, [&] {
    return Store::create(output_->make(), std::move(base), plan_.store, backends_);
  });
}

void SubdivisionJob::commit() {
  const Stopwatch clock;
  store_->commit();
  report_.commit_seconds += clock.seconds();
}

void SubdivisionJob::refine() {
  const Stopwatch clock;
  if (!store_) store_ = create_store(std::move(base_.mesh));
  base_ = {};
  Store& store = *store_;
  const bool fresh = store.attributes().empty();
  if (fresh) add_base_positions(store, plan_.double_precision);
  report_.resumed_level = store.finest_level();
  report_.base_mesh_bytes =
      store.base().memory_bytes() + subdivide_resident_bytes(store, plan_.subdivide);
  // Normals fit the level that they were made for: they are replaced in the commit that ends the
  // surface they belong to.
  const bool by_levels = plan_.commits_levels && !store.has_attribute("normal");
  if (fresh || !is_finished(store, plan_.subdivide)) {
    if (!request_.ignore_size) require_budget(store, plan_.subdivide);
    if (fresh && by_levels) commit();
    if (by_levels) plan_.subdivide.level_done = [&](int) { commit(); };
    plan_.subdivide.proceed = events_.proceed;
    try {
      subdivide(store, plan_.subdivide);
    } catch (const Error& error) {
      if (!plan_.commits_levels || error.code() != ErrorCode::kCancelled) throw;
      throw Error(error.code(), std::string(error.what()) + "; what is committed of " +
                                    store.path().native() +
                                    " stays, and --resume goes on from there");
    }
    commit();
  }
  report_.refine_seconds += clock.seconds() - report_.commit_seconds;
  describe();
}

void SubdivisionJob::finish() {
  store_->close();
  if (output_) output_->publish(plan_.store.durability == Durability::kCommit);
}

void SubdivisionJob::describe() {
  const Store& store = *store_;
  report_.mesh = request_.mesh;
  report_.store = output_ ? output_->final_path() : store.path();
  report_.levels = request_.levels;
  report_.base_level = store.base_level();
  report_.layout = store.options().layout;
  report_.paging = store.statistics();
  report_.stored_bytes = store.stored_bytes();
  for (AttributeId id = 0; id < store.attributes().size(); ++id)
    report_.base_mesh_bytes +=
        store.base().vertex_count() * store.attributes()[id].schema.record_bytes();
  report_.budget_bytes = plan_.store.budget_bytes;
  report_.block_bytes = store.options().block_bytes;
  report_.backend = store.options().backend;
  report_.backend_reason = plan_.backend_reason;
  const PipelineFlags pipeline = PipelineFlags::of(store.options().pipeline);
  report_.codec = pipeline.codec;
  report_.filter = pipeline.filter;
  report_.durability = request_.durable ? "commit" : "none";
  report_.executor = to_string(plan_.subdivide.executor);
  report_.threads = plan_.subdivide.threads;
  report_.scheme = to_string(plan_.subdivide.scheme);
  report_.precision = plan_.double_precision ? "float64" : "float32";
  report_.normals = request_.normals;
  report_.limit = request_.limit;
}

}  // namespace plait
