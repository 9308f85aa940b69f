#include "subdivide/plan.h"

#include <fmt/format.h>

#include "pipeline_flags.h"
#include "plait/error.h"

namespace plait {
namespace {

constexpr std::uint64_t kMaxSlotBytes = 16 << 10;

void choose_executor(const SubdivisionRequest& request, SubdivisionPlan& plan) {
  SubdivideOptions& subdivide = plan.subdivide;
  subdivide.executor = request.executor != "auto" ? executor_from_name(request.executor)
                       : request.resume           ? ExecutorKind::kSweep
                                                  : ExecutorKind::kFused;
  subdivide.threads = subdivide.executor == ExecutorKind::kTransparent ? 1 : request.threads;
  // Of the fused executor what is under way at once decides, not how far stencils reach.
  if (plan.layout == LayoutKind::kAutomatic && subdivide.executor == ExecutorKind::kFused)
    plan.layout = LayoutKind::kHilbert;
}

}  // namespace

SubdivisionPlan make_plan(const SubdivisionRequest& request, const BackendRegistry& backends) {
  SubdivisionPlan plan;
  plan.store.backend = request.backend.value_or(kAutomaticBackend);
  const BackendRegistry::Entry* backend =
      plan.store.backend == kAutomaticBackend ? nullptr : &backends.find(plan.store.backend);
  plan.keeps_store = backend == nullptr || backend->traits.durable;
  if (backend != nullptr) {
    PipelineFlags parts = PipelineFlags::of(backend->default_pipeline);
    if (request.codec) parts.codec = *request.codec;
    if (request.filter) parts.filter = *request.filter;
    plan.store.pipeline = parts.pipeline();
    backend->validate(BackendRegistry::options_in(plan.store.backend));
    backend->validate_pipeline(plan.store.pipeline);
    plan.backend_reason = "asked for";
  }
  plan.store.block_bytes = request.block_bytes.value_or(StoreOptions().block_bytes);
  plan.store.budget_bytes = request.memory_bytes;
  plan.store.durability = request.durable ? Durability::kCommit : Durability::kNone;
  plan.max_slot_bytes = request.max_slot_bytes.value_or(kMaxSlotBytes);

  plan.layout = layout_from_name(request.layout.value_or("auto"));
  plan.double_precision = request.precision == "float64";
  plan.subdivide.scheme = scheme_from_name(request.scheme.value_or("loop"));
  plan.subdivide.levels = request.levels;
  plan.subdivide.normals = request.normals;
  plan.subdivide.limit = request.limit;
  plan.commits_levels = request.resume;
  choose_executor(request, plan);

  if (request.resume &&
      (request.limit || !plan.keeps_store || plan.subdivide.executor == ExecutorKind::kFused))
    throw Error(ErrorCode::kInvalidArgument,
                "subdivide: --resume needs a backend that keeps levels and an executor that makes "
                "one after another (sweep, transparent), and goes without --limit");
  if (plan.keeps_store && request.store.empty())
    throw Error(ErrorCode::kInvalidArgument,
                "subdivide: STORE is missing; only a backend that keeps nothing goes without");
  return plan;
}

void require_compression(const SubdivisionRequest& request, const BackendRegistry& backends) {
  if (!request.codec && !request.filter) return;
  const std::string backend = request.backend.value_or(kAutomaticBackend);
  if (backend == kAutomaticBackend || !backends.find(backend).traits.compressed)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("subdivide: --codec and --filter need a backend that compresses, and "
                            "--backend {} does not: add --backend compressed",
                            backend));
}

}  // namespace plait
