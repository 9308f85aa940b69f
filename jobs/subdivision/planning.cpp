#include "subdivision/planning.h"

#include <fmt/format.h>

#include <filesystem>
#include <span>
#include <system_error>
#include <utility>

#include "job_rules.h"
#include "plait/error.h"
#include "schemes/table.h"
#include "store/unpublished_store.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// The memory of the fused executor depends on how many patches are unfinished at once, and not on
/// the span of the layout.
LayoutKind layout_of(const SubdivisionRequest& request, ExecutorKind executor) {
  const LayoutKind layout = request.layout.value_or(LayoutKind::kAutomatic);
  return layout == LayoutKind::kAutomatic && executor == ExecutorKind::kFused ? LayoutKind::kHilbert
                                                                              : layout;
}

void check_resumable(const SubdivisionRequest& request, SubdivisionPlan& plan) {
  if (!plan.commits_levels) return;
  const auto refuse_it = [&](std::string_view option, const char* why) {
    refuse(plan, option, ErrorCode::kInvalidArgument,
           fmt::format("subdivide: a run that can be resumed {}", why));
  };
  if (!plan.keeps_store) refuse_it("backend", "needs a backend that stores levels in files");
  if (plan.subdivide.executor == ExecutorKind::kFused)
    refuse_it("executor",
              "needs an executor that makes one level after another (sweep, transparent)");
  if (request.limit)
    refuse_it("limit",
              "cannot make limit positions, because no subdivision can continue from these");
}

void check_distance(const SubdivisionRequest& request, SubdivisionPlan& plan) {
  if (!request.max_distance) return;
  if (!(*request.max_distance >= 0))
    refuse(plan, "max-distance", ErrorCode::kInvalidArgument,
           fmt::format("subdivide: largest distance: expected 0 or more, found {}",
                       *request.max_distance));
  if (plan.commits_levels)
    refuse(plan, "resume", ErrorCode::kInvalidArgument,
           "subdivide: a run that can be resumed makes all levels of all faces: expected resume or "
           "max-distance, found both: prune a copy of the finished store");
  if (!plan.keeps_store)
    refuse(plan, "backend", ErrorCode::kInvalidArgument,
           fmt::format("subdivide: max-distance: expected a backend that stores levels in files, "
                       "found {}",
                       plan.store.backend));
}

void choose_pipelines(const SubdivisionRequest& request, const RegisteredBackend& backend,
                      SubdivisionPlan& plan) {
  plan.store.pipeline_of = request.pipeline_of;
  const AttributeSchema position{"position", request.precision.value_or(ComponentType::kFloat32),
                                 3};
  backend.check_pipelines(request.pipeline_of(position), position);
  if (request.normals) {
    const AttributeSchema normal{"normal", ComponentType::kFloat32, 3};
    backend.check_pipelines(request.pipeline_of(normal), normal);
  }
  if (request.resume && backend.needs_other_blocks(request.pipeline_of(position), position))
    refuse(plan, "compress", ErrorCode::kInvalidArgument,
           fmt::format("subdivide: a run that can be resumed needs blocks that are encoded without "
                       "other blocks, found pipeline {}",
                       request.pipeline_of(position).to_text()));
}

/// A resumable run never has limit positions: check_resumable() refuses them.
void check_limit(const SubdivisionRequest& request, SubdivisionPlan& plan) {
  if (!request.limit || plan.commits_levels) return;
  if (const SchemeTraits scheme = traits_of(plan.subdivide.scheme); !scheme.has_limits)
    refuse(plan, "limit", ErrorCode::kNotSupported,
           fmt::format("subdivide: scheme {} has no limit positions", scheme.name));
}

/// Refuses bounds of attributes that the run does not make, and bounds that no step suits.
/// `corners` contain the records that follow from the mesh, as far as they are known.
void check_bound(const SubdivisionRequest& request, const AttributeSchema& schema,
                 std::span<const std::byte> corners, SubdivisionPlan& plan) {
  const auto bound = request.max_errors.of(schema.name);
  if (!bound) return;
  try {
    const Rounder takes_it(schema, *bound, corners);
  } catch (const Error& error) {
    refuse(plan, "max-error", error.code(), fmt::format("subdivide: {}", error.what()));
  }
}

}  // namespace

void refuse(SubdivisionPlan& plan, std::string_view option, ErrorCode code, std::string reason) {
  plan.refusals.push_back({std::string(option), code, std::move(reason)});
}

void throw_refusal(const SubdivisionPlan& plan) {
  if (plan.refusals.empty()) return;
  const SubdivisionRefusal& first = plan.refusals.front();
  throw JobError(first.code, first.reason, first.option);
}

SubdivisionPlan plan_request(const SubdivisionRequest& request, const BackendRegistry& backends) {
  SubdivisionPlan plan;
  if (request.resume && request.existing == Existing::kReplace)
    refuse(plan, {}, ErrorCode::kInvalidArgument,
           "subdivide: expected force or resume, found both");
  if (request.resume && !request.max_errors.empty())
    refuse(plan, "max-error", ErrorCode::kInvalidArgument,
           "subdivide: a run that can be resumed cannot round records, because finer levels are "
           "made from exact ones: round a copy of the finished store");
  plan.backend_reason = "given by the user";
  plan.store.backend = request.backend.value_or(std::string(kAutomaticBackend));
  plan.keeps_store = true;
  // Without pipelines, the size of the levels decides, which depends on the mesh.
  if (plan.store.backend == kAutomaticBackend && request.pipeline_of) {
    BackendChoice choice = backends.choose({.path = request.store, .has_pipelines = true});
    plan.store.backend = std::move(choice.name);
    plan.backend_reason = std::move(choice.reason);
  }
  if (plan.store.backend != kAutomaticBackend) {
    const RegisteredBackend& backend = backends.find(plan.store.backend);
    backend.check_machine();
    if (request.pipeline_of && backend.traits.compressed) choose_pipelines(request, backend, plan);
    plan.keeps_store = backend.traits.durable;
  }
  plan.store.block_bytes = request.block_bytes.value_or(0);
  plan.store.budget_bytes = request.budget_bytes;
  plan.store.durability = request.durability;
  plan.store.parallel_for = request.parallel_for;
  if (request.no_index) plan.store.base_index = false;
  plan.precision = request.precision.value_or(ComponentType::kFloat32);
  plan.commits_levels = request.resume;

  plan.subdivide.scheme = request.scheme.value_or(Scheme());
  plan.subdivide.levels = request.levels;
  plan.subdivide.normals = request.normals;
  plan.subdivide.limit = request.limit;
  plan.subdivide.executor = request.executor;
  if (request.executor == ExecutorKind::kAuto)
    plan.subdivide.executor = plan.commits_levels ? ExecutorKind::kSweep : ExecutorKind::kFused;
  plan.subdivide.threads =
      plan.subdivide.executor == ExecutorKind::kTransparent ? 1 : request.threads;
  plan.layout = layout_of(request, plan.subdivide.executor);

  check_resumable(request, plan);
  check_distance(request, plan);
  check_limit(request, plan);
  if (plan.precision != ComponentType::kFloat32 && plan.precision != ComponentType::kFloat64)
    refuse(plan, "precision", ErrorCode::kInvalidArgument,
           fmt::format("subdivide: expected precision float32 or float64, found {}",
                       to_string(plan.precision)));
  if (request.weld && !std::holds_alternative<std::filesystem::path>(request.mesh))
    refuse(plan, "input", ErrorCode::kInvalidArgument,
           "subdivide: expected a file to weld, found a mesh whose faces are connected");
  if (plan.keeps_store && request.store.empty())
    refuse(plan, "output", ErrorCode::kInvalidArgument,
           "subdivide: expected a name for the store, found none; only a backend without files "
           "needs none");
  if (plan.refusals.empty() && !plan.keeps_store && !request.store.empty())
    plan.warnings.push_back(fmt::format("backend {} writes no files: {} is not made",
                                        plan.store.backend, request.store.native()));
  return plan;
}

void check_compression(const SubdivisionRequest& request, const BackendRegistry& backends,
                       SubdivisionPlan& plan) {
  if (!request.pipeline_of) return;
  const RegisteredBackend& backend = backends.find(plan.store.backend);
  if (backend.traits.compressed) return;
  const JobError refusal = needs_compression("subdivide", backend);
  refuse(plan, refusal.option(), refusal.code(), refusal.what());
}

void check_bounds(const SubdivisionRequest& request, const BaseMesh& mesh, SubdivisionPlan& plan) {
  for (const auto& [name, bound] : request.max_errors.all())
    if (name != "position" && !(name == "normal" && request.normals))
      refuse(plan, "max-error", ErrorCode::kInvalidArgument,
             fmt::format("subdivide: expected error bounds of {}, found one of '{}'{}",
                         request.normals ? "position and normal" : "position", name,
                         name == "normal" ? ", which is not asked for" : ""));
  if (request.verify && request.max_errors.empty())
    refuse(plan, "max-error", ErrorCode::kInvalidArgument,
           "subdivide: expected an error bound to verify, found none");
  if (request.max_errors.of("position"))
    check_bound(request, {"position", ComponentType::kFloat64, 3}, std::as_bytes(mesh.positions()),
                plan);
  constexpr float kUnitBox[] = {-1, -1, -1, 1, 1, 1};
  check_bound(request, {"normal", ComponentType::kFloat32, 3}, std::as_bytes(std::span(kUnitBox)),
              plan);
}

void check_name(const SubdivisionRequest& request, SubdivisionPlan& plan) {
  if (!plan.keeps_store || plan.commits_levels) return;
  try {
    UnpublishedStore::check(request.store, request.existing);
  } catch (const Error& error) {
    std::error_code ignored;
    const bool taken =
        std::filesystem::exists(std::filesystem::symlink_status(request.store, ignored));
    refuse(plan, taken && request.existing == Existing::kRefuse ? "force" : "output", error.code(),
           error.what());
  }
}

PLAIT_END_NAMESPACE
