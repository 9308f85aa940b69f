#include "subdivision_job/planning.h"

#include <fmt/format.h>

#include <filesystem>
#include <span>
#include <system_error>
#include <utility>

#include "plait/block_maker.h"
#include "plait/error.h"
#include "plait/level_pipelines.h"
#include "plait/partial_store.h"
#include "schemes/table.h"

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
  const auto refuse_it = [&](std::string_view field, const char* why) {
    refuse(plan, field, ErrorCode::kInvalidArgument,
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

/// An attribute whose blocks are encoded from other blocks is made with the backend's interim
/// pipeline first, because the executors do not finish one level before the next. A stage
/// `predicted` stays: its blocks need no others.
void choose_pipelines(const SubdivisionRequest& request, const BackendRegistry::Entry& backend,
                      SubdivisionPlan& plan) {
  plan.store.pipeline_of = [backend, wanted = request.pipeline_of](const AttributeSchema& schema) {
    const auto alone = [&](std::string_view pipeline) {
      if (!backend.needs_other_blocks(pipeline, schema)) return std::string(pipeline);
      const std::string interim =
          backend.interim_pipeline ? backend.interim_pipeline(schema) : backend.default_pipeline;
      return has_predicted_stage(pipeline) ? fmt::format("{}+{}", kPredictedStage, interim)
                                           : interim;
    };
    return LevelPipelines::parse(wanted(schema)).changed(alone).to_text();
  };
  const AttributeSchema position{"position", request.precision.value_or(ComponentType::kFloat32),
                                 3};
  backend.validate_pipeline(request.pipeline_of(position), position);
  if (request.normals && !request.derive_normals) {
    const AttributeSchema normal{"normal", ComponentType::kFloat32, 3};
    backend.validate_pipeline(request.pipeline_of(normal), normal);
  }
  if (request.existing == ExistingStore::kResume &&
      backend.needs_other_blocks(request.pipeline_of(position), position))
    refuse(plan, "pipeline_of", ErrorCode::kInvalidArgument,
           fmt::format("subdivide: a run that can be resumed needs blocks that are encoded without "
                       "other blocks, found pipeline {}",
                       request.pipeline_of(position)));
}

void check_derived(const SubdivisionRequest& request, SubdivisionPlan& plan) {
  if (!request.derive_normals) return;
  if (request.limit)
    refuse(plan, "limit", ErrorCode::kInvalidArgument,
           "subdivide: derived normals are those of the stored positions, and limit positions have "
           "others than the surface: leave one of the two out");
  if (plan.commits_levels)
    refuse(plan, "derive_normals", ErrorCode::kInvalidArgument,
           "subdivide: a run that can be resumed stores its normals: convert the store when it is "
           "finished");
}

/// A resumable run never has limit positions: check_resumable() refuses them.
void check_limit(const SubdivisionRequest& request, SubdivisionPlan& plan) {
  if (!request.limit || plan.commits_levels) return;
  if (const SchemeTraits scheme = traits_of(plan.subdivide); !scheme.has_limits)
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
    refuse(plan, "max_errors", error.code(), fmt::format("subdivide: {}", error.what()));
  }
}

}  // namespace

void refuse(SubdivisionPlan& plan, std::string_view field, ErrorCode code, std::string reason) {
  plan.refusals.push_back({field, code, std::move(reason)});
}

void throw_refusal(const SubdivisionPlan& plan) {
  if (plan.refusals.empty()) return;
  throw Error(plan.refusals.front().code, plan.refusals.front().reason);
}

SubdivisionPlan plan_request(const SubdivisionRequest& request, const BackendRegistry& backends) {
  SubdivisionPlan plan;
  if (request.existing == ExistingStore::kResume && !request.max_errors.empty())
    refuse(plan, "max_errors", ErrorCode::kInvalidArgument,
           "subdivide: a run that can be resumed cannot round records, because finer levels are "
           "made from exact ones: round a copy of the finished store");
  plan.store.backend = request.backend.value_or("");
  plan.keeps_store = true;
  if (request.backend) {
    const BackendRegistry::Entry& backend = backends.find(*request.backend);
    backend.validate(BackendRegistry::options_in(*request.backend));
    if (request.pipeline_of && backend.traits.compressed) choose_pipelines(request, backend, plan);
    plan.keeps_store = backend.traits.durable;
    plan.backend_reason = "given by the user";
  }
  plan.store.block_bytes = request.block_bytes.value_or(StoreOptions().block_bytes);
  plan.store.budget_bytes = request.budget_bytes;
  plan.store.durability = request.durability;
  plan.precision = request.precision.value_or(ComponentType::kFloat32);
  plan.commits_levels = request.existing == ExistingStore::kResume;

  plan.subdivide.scheme = request.scheme.value_or(kDefaultScheme);
  if (request.own_scheme) plan.subdivide.own_scheme = &*request.own_scheme;
  plan.subdivide.levels = request.levels;
  plan.subdivide.normals = request.normals && !request.derive_normals;
  plan.subdivide.limit = request.limit;
  plan.subdivide.executor =
      request.executor.value_or(plan.commits_levels ? ExecutorKind::kSweep : ExecutorKind::kFused);
  plan.subdivide.threads =
      plan.subdivide.executor == ExecutorKind::kTransparent ? 1 : request.threads;
  plan.layout = layout_of(request, plan.subdivide.executor);

  if (request.scheme && request.own_scheme)
    refuse(plan, "scheme", ErrorCode::kInvalidArgument,
           fmt::format("subdivide: expected one scheme, found {} and the program's own {}",
                       to_string(*request.scheme), request.own_scheme->name()));
  check_derived(request, plan);
  check_resumable(request, plan);
  check_limit(request, plan);
  if (plan.precision != ComponentType::kFloat32 && plan.precision != ComponentType::kFloat64)
    refuse(plan, "precision", ErrorCode::kInvalidArgument,
           fmt::format("subdivide: expected precision float32 or float64, found {}",
                       to_string(plan.precision)));
  if (plan.keeps_store && request.store.empty())
    refuse(plan, "store", ErrorCode::kInvalidArgument,
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
  if (request.backend && backends.find(*request.backend).traits.compressed) return;
  refuse(plan, "backend", ErrorCode::kInvalidArgument,
         fmt::format("subdivide: pipelines need a backend that compresses, such as compressed, "
                     "found backend {}",
                     request.backend.value_or("auto")));
}

void check_bounds(const SubdivisionRequest& request, const BaseMesh& mesh, SubdivisionPlan& plan) {
  for (const auto& [name, bound] : request.max_errors.all())
    if (name != "position" && !(name == "normal" && request.normals))
      refuse(plan, "max_errors", ErrorCode::kInvalidArgument,
             fmt::format("subdivide: expected error bounds of {}, found one of '{}'{}",
                         request.normals ? "position and normal" : "position", name,
                         name == "normal" ? ", which is not asked for" : ""));
  if (request.verify && request.max_errors.empty())
    refuse(plan, "verify", ErrorCode::kInvalidArgument,
           "subdivide: expected an error bound to verify, found none");
  check_bound(request, {"position", ComponentType::kFloat64, 3}, std::as_bytes(mesh.positions()),
              plan);
  constexpr float kUnitBox[] = {-1, -1, -1, 1, 1, 1};
  check_bound(request, {"normal", ComponentType::kFloat32, 3}, std::as_bytes(std::span(kUnitBox)),
              plan);
}

void check_name(const SubdivisionRequest& request, SubdivisionPlan& plan) {
  if (!plan.keeps_store || plan.commits_levels) return;
  const bool replaces = request.existing == ExistingStore::kReplace;
  try {
    PartialStore::check(request.store, replaces ? Existing::kReplace : Existing::kRefuse);
  } catch (const Error& error) {
    std::error_code ignored;
    const bool taken =
        std::filesystem::exists(std::filesystem::symlink_status(request.store, ignored));
    refuse(plan, taken && !replaces ? "existing" : "store", error.code(), error.what());
  }
}

PLAIT_END_NAMESPACE
