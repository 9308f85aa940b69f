#include "subdivision/mesh_in_pieces.h"

#include <fmt/format.h>

#include <filesystem>
#include <string>
#include <variant>

#include "base/text.h"
#include "io/unpublished.h"
#include "job_rules.h"
#include "layout/base_directory.h"
#include "schemes/table.h"
#include "subdivision/planning.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// What needs the whole mesh, or nothing.
std::string reason_of(const SubdivisionRequest& request, const SubdivisionPlan& plan) {
  if (plan.subdivide.executor != ExecutorKind::kFused)
    return fmt::format("executor {}{} reads all of it", to_string(plan.subdivide.executor),
                       plan.commits_levels ? " of a run that can be resumed" : "");
  if (plan.layout != kLayoutOfBaseDirectory)
    return fmt::format("layout {} orders all faces anew, {} keeps their order",
                       to_string(plan.layout), to_string(kLayoutOfBaseDirectory));
  if (traits_of(plan.subdivide.scheme).ring_count > 1)
    return fmt::format("scheme {} has level 1 of all of it in memory",
                       to_string(plan.subdivide.scheme));
  if (request.levels < 1) return "level 0 is no work of the fused executor";
  if (request.max_distance) return "depths of faces (--max-distance) are chosen for all of it";
  if (!request.max_errors.empty()) return "records are rounded (--max-error) by all of it";
  return {};
}

void refuse_it(const SubdivisionRequest& request, const std::string& why, SubdivisionPlan& plan) {
  const auto& mesh = std::get<std::filesystem::path>(request.mesh);
  refuse(
      plan, "memory", ErrorCode::kBudget,
      fmt::format("subdivide: {} needs {} of memory as a whole, found a budget of {}, with which "
                  "it is taken in pieces: {}: give more than {}",
                  mesh.native(), format_bytes(BaseInRanges::whole_bytes(mesh)),
                  format_bytes(request.budget_bytes), why,
                  format_bytes(BaseInRanges::whole_bytes(mesh))));
}

}  // namespace

std::optional<BaseInRanges> mesh_in_pieces(const SubdivisionRequest& request,
                                           SubdivisionPlan& plan) {
  const auto* const mesh = std::get_if<std::filesystem::path>(&request.mesh);
  if (mesh == nullptr || request.weld || !plan.keeps_store || plan.earlier ||
      !is_base_directory(*mesh) || BaseInRanges::whole_bytes(*mesh) <= request.budget_bytes)
    return std::nullopt;
  if (const std::string why = reason_of(request, plan); !why.empty()) {
    refuse_it(request, why, plan);
    return std::nullopt;
  }
  const std::filesystem::path store = OutputName(request.store).path;
  if (const auto line = disk_for_sorts(
          fmt::format("subdivide {}", mesh->native()), store,
          BaseInRanges::disk_of_narrowing(BaseInRanges::counts(*mesh), request.budget_bytes)))
    plan.warnings.push_back(*line);
  plan.piece_bytes = request.budget_bytes / 2;
  plan.store.budget_bytes = request.budget_bytes - plan.piece_bytes;
  return std::make_optional<BaseInRanges>(*mesh, store, request.budget_bytes);
}

void refuse_pieces(const SubdivisionRequest& request, const BackendTraits& backend,
                   SubdivisionPlan& plan) {
  if (plan.piece_bytes == 0) return;
  if (backend.compressed)
    refuse_it(request, "backend compressed encodes blocks with the help of all of it", plan);
  if (plan.base_level > 0)
    refuse_it(request,
              fmt::format("it is refined {} times in memory first (--max-slot)", plan.base_level),
              plan);
}

PLAIT_END_NAMESPACE
