#include "subdivide/resume.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <string_view>

#include "arguments.h"
#include "pipeline_flags.h"
#include "plait/error.h"

namespace plait {
namespace {

[[noreturn]] void refuse(const Store& store, const std::string& reason) {
  throw Error(ErrorCode::kInvalidArgument,
              fmt::format("resume {}: {}", store.path().native(), reason));
}

/// `open` is what leaves the choice to the store, such as "auto".
void require_same(const Store& store, std::string_view option,
                  const std::optional<std::string>& asked, std::string_view found,
                  std::string_view open = "auto") {
  if (asked && *asked != found && *asked != open)
    refuse(store, fmt::format("{} {} was asked for, and the store has {}: leave the option out, "
                              "or convert the store",
                              option, *asked, found));
}

void require_same_representation(const Store& store, const SubdivisionRequest& request) {
  const StoreOptions& has = store.options();
  const PipelineFlags pipeline = PipelineFlags::of(has.pipeline);
  require_same(store, "--backend", request.backend, has.backend);
  require_same(store, "--codec", request.codec, pipeline.codec);
  require_same(store, "--filter", request.filter, pipeline.filter);
  require_same(store, "--layout", request.layout, has.layout);
  if (request.block_bytes && *request.block_bytes != has.block_bytes)
    refuse(store, fmt::format("--block {} was asked for, and the store has blocks of {}: leave the "
                              "option out, or convert the store",
                              size_text(*request.block_bytes), size_text(has.block_bytes)));
}

bool has_levels(const Store& store) { return store.finest_level() > store.base_level(); }

void require_same_surface(const Store& store, const SubdivisionRequest& request) {
  const Provenance& provenance = store.provenance();
  if (provenance.limit)
    refuse(store, "it holds limit positions, from which no subdivision can go on");
  if (has_levels(store)) {
    if (provenance.scheme.empty()) refuse(store, "it does not say which scheme made its levels");
    require_same(store, "--scheme", request.scheme, provenance.scheme, "");
  }
  const AttributeInfo& position = store.attributes()[store.attribute("position")];
  require_same(store, "--precision", request.precision, to_string(position.schema.type), "");
  if (position.finest_level > request.levels)
    refuse(store, fmt::format("expected level {} at most, found level {}", request.levels,
                              position.finest_level));
  if (store.has_attribute("normal") && position.finest_level < request.levels && !request.normals)
    refuse(store, fmt::format("it has normals of level {}, which fit no finer one: --normals makes "
                              "them anew",
                              position.finest_level));
  if (!request.max_slot_bytes) return;
  const int base_level =
      rebase_levels(request.levels, position.schema.record_bytes(), *request.max_slot_bytes);
  if (base_level != store.base_level())
    refuse(store, fmt::format("--max-slot {} asks for a base mesh refined {} times, and the store "
                              "has one refined {} times: leave the option out",
                              size_text(*request.max_slot_bytes), base_level, store.base_level()));
}

}  // namespace

std::optional<Store> open_earlier_run(const SubdivisionRequest& request,
                                      const BackendRegistry& backends, SubdivisionPlan& plan) {
  if (!request.resume || !std::filesystem::exists(request.store)) return {};
  // A writer that was killed before its first commit left nothing to go on from.
  if (!Store::has_commit(request.store)) return {};
  OpenOptions open;
  open.writable = true;
  open.budget_bytes = plan.store.budget_bytes;
  open.durability = plan.store.durability;
  Store store = Store::open(request.store, open, backends);
  require_same_representation(store, request);
  require_same_surface(store, request);
  const AttributeInfo& position = store.attributes()[store.attribute("position")];
  if (has_levels(store)) plan.subdivide.scheme = scheme_from_name(store.provenance().scheme);
  plan.double_precision = position.schema.type == ComponentType::kFloat64;
  plan.layout = layout_from_name(store.options().layout);
  plan.store = store.options();
  plan.backend_reason = "as the store was made";
  return store;
}

void require_same_mesh(const Store& store, const BaseMesh& mesh) {
  if (!std::ranges::equal(store.base().faces(), mesh.faces()) ||
      !std::ranges::equal(store.base().positions(), mesh.positions(),
                          [](const Vector3<double>& a, const Vector3<double>& b) {
                            return a.x == b.x && a.y == b.y && a.z == b.z;
                          }))
    refuse(store, "its base mesh is another one than the mesh that was given");
}

bool is_finished(const Store& store, const SubdivideOptions& subdivision) {
  const AttributeInfo& position = store.attributes()[store.attribute("position")];
  return position.finest_level == subdivision.levels &&
         (!subdivision.normals || store.has_attribute("normal"));
}

}  // namespace plait
