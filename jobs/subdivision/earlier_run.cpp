#include "subdivision/earlier_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <string_view>

#include "base/text.h"
#include "plait/error.h"
#include "plait/extend/pipeline.h"
#include "plait/extend/store_access.h"
#include "subdivision/planning.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

bool is_of_library(std::string_view scheme) {
  return std::ranges::find(schemes(), scheme, &SchemeTraits::name) != schemes().end();
}

/// Compares a request with a store, and adds a refusal to the plan for each difference.
class Comparison {
 public:
  Comparison(const Store& store, const SubdivisionRequest& request, SubdivisionPlan& plan)
      : store_(store),
        request_(request),
        plan_(plan),
        position_(store.attributes()[store.attribute("position")]) {}

  void representation() {
    const StoreOptions& has = store_.options();
    if (request_.backend && *request_.backend != kAutomaticBackend)
      same("backend", "backend", *request_.backend, has.backend);
    if (request_.pipeline_of) pipelines();
    if (request_.layout && *request_.layout != LayoutKind::kAutomatic)
      same("layout", "layout", to_string(*request_.layout), store_.provenance().layout);
    if (request_.block_bytes)
      same("block", "block size", size_text(*request_.block_bytes), size_text(has.block_bytes));
  }

  void surface(bool has_levels) {
    const Provenance& provenance = store_.provenance();
    if (provenance.limit)
      refuse_store("force",
                   "its positions are limit positions, and no subdivision can continue from these");
    if (StoreAccess::rounding(store_, store_.attribute("position")))
      refuse_store("force",
                   "its positions are rounded, and finer levels are made from exact "
                   "ones");
    else if (has_levels && provenance.scheme.empty())
      refuse_store("force", "it does not say which scheme made its levels");
    else if (has_levels && request_.scheme)
      same("scheme", "scheme", to_string(*request_.scheme), provenance.scheme);
    else if (has_levels && !is_of_library(provenance.scheme))
      refuse_store("scheme", fmt::format("the scheme '{}' made its levels, which is none of the "
                                         "library: give the program's own scheme",
                                         provenance.scheme));
    if (request_.precision)
      same("precision", "precision", to_string(*request_.precision),
           to_string(position_.schema.type));
    if (position_.finest_level > request_.levels)
      refuse_store("levels", fmt::format("expected level {} at most, found level {}",
                                         request_.levels, position_.finest_level));
    if (store_.has_attribute("normal") && position_.finest_level < request_.levels &&
        !request_.normals)
      refuse_store("normals", fmt::format("it has normals of level {}, which do not fit a finer "
                                          "level: ask for normals, so that new ones are computed",
                                          position_.finest_level));
    base_level();
  }

 private:
  void base_level() {
    if (!request_.max_slot_bytes) return;
    const int asked =
        rebase_levels(request_.levels, position_.schema.record_bytes(), *request_.max_slot_bytes);
    if (asked != store_.base_level())
      refuse_store("max-slot",
                   fmt::format("for slots of at most {}, the base mesh would be refined {} times, "
                               "but in the store it is refined {} times: leave the option out",
                               size_text(*request_.max_slot_bytes), asked, store_.base_level()));
  }

  /// Refuses at most one of the levels: one option names them all.
  void pipelines() {
    for (AttributeId id = 0; id < store_.attributes().size(); ++id) {
      const AttributeInfo& info = store_.attributes()[id];
      const LevelPipelines pipelines = request_.pipeline_of(info.schema);
      for (int level = store_.base_level() + 1; level <= info.finest_level; ++level)
        if (const Pipeline& asked = pipelines.of(level),
            &found = StoreAccess::level_file(store_, id, level).pipeline;
            found.with_recipe({}) != asked.with_recipe({}))
          return same("compress", "pipeline", asked.to_text(), found.to_text());
    }
  }

  void same(std::string_view option, std::string_view name, std::string_view asked,
            std::string_view found) {
    if (asked != found)
      refuse_store(option, fmt::format("the request has {} {}, but the store has {}: leave the "
                                       "option out, or convert the store",
                                       name, asked, found));
  }
  void refuse_store(std::string_view option, const std::string& reason) {
    refuse(plan_, option, ErrorCode::kInvalidArgument,
           fmt::format("resume {}: {}", store_.path().native(), reason));
  }

  const Store& store_;
  const SubdivisionRequest& request_;
  SubdivisionPlan& plan_;
  const AttributeInfo& position_;
};

}  // namespace

std::optional<Store> open_earlier_run(const SubdivisionRequest& request,
                                      const BackendRegistry& backends, SubdivisionPlan& plan) {
  if (!plan.commits_levels || !std::filesystem::exists(request.store)) return {};
  // A writer that was killed before its first commit left nothing to continue from.
  if (!Store::has_commit(request.store)) return {};
  OpenOptions open;
  open.writable = true;
  open.budget_bytes = plan.store.budget_bytes;
  open.durability = plan.store.durability;
  open.base_index = plan.store.base_index;
  open.parallel_for = plan.store.parallel_for;
  Store store = Store::open(request.store, open, backends);
  StoreAccess::refuse_depths(store, "resume", store.finest_level());
  const bool has_levels = store.finest_level() > store.base_level();
  Comparison comparison(store, request, plan);
  comparison.representation();
  comparison.surface(has_levels);
  if (!plan.refusals.empty()) return {};

  const AttributeInfo& position = store.attributes()[store.attribute("position")];
  if (has_levels && !request.scheme)
    plan.subdivide.scheme = scheme_from_name(store.provenance().scheme);
  plan.precision = position.schema.type;
  plan.layout = layout_from_name(store.provenance().layout);
  plan.base_level = store.base_level();
  plan.store = store.options();
  plan.backend_reason = "the backend of the store";
  EarlierRun& earlier = plan.earlier.emplace();
  earlier.level = position.finest_level;
  earlier.normals = store.has_attribute("normal");
  earlier.finished =
      earlier.level == request.levels && (earlier.normals || !plan.subdivide.normals);
  return store;
}

void check_same_mesh(const Store& store, const BaseMesh& mesh, SubdivisionPlan& plan) {
  if (!std::ranges::equal(store.base().faces(), mesh.faces()) ||
      !std::ranges::equal(store.base().positions(), mesh.positions(),
                          [](const Vector3<double>& a, const Vector3<double>& b) {
                            return a.x == b.x && a.y == b.y && a.z == b.z;
                          }))
    refuse(plan, "input", ErrorCode::kInvalidArgument,
           fmt::format("resume {}: the store was made from another mesh than the given one",
                       store.path().native()));
}

PLAIT_END_NAMESPACE
