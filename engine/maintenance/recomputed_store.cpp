#include "maintenance/recomputed_store.h"

#include <fmt/format.h>

#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// The built-in one, or whichever a program has put in its place.
std::optional<std::string> memory_backend(const BackendRegistry& backends) {
  for (const std::string& name : backends.names())
    if (const BackendTraits& traits = backends.find(name).traits; traits.in_memory) return name;
  return std::nullopt;
}

Recomputation plan(const StoreCheck& check, const PlanRecomputation& recompute) {
  const bool base_known = check.base.edge_count() > 0;
  if (base_known && recompute) return recompute(check);
  Recomputation nothing;
  nothing.refusal = [base_known](std::string_view attribute) {
    return base_known ? fmt::format("nothing was given that makes attribute '{}' anew", attribute)
                      : "base.mesh, from which attributes are computed anew, is damaged";
  };
  return nothing;
}

}  // namespace

RecomputedStore::RecomputedStore(const StoreCheck& check, const RepairOptions& options,
                                 const BackendRegistry& backends, PartialDirectory& scratch,
                                 const PlanRecomputation& recompute)
    : check_(check),
      options_(options),
      backends_(backends),
      scratch_(scratch),
      recomputation_(plan(check, recompute)) {}

Store& RecomputedStore::made() {
  if (made_) return *made_;
  StoreOptions store = check_.options;
  store.pipeline.clear();  // whatever keeps the levels here
  store.durability = Durability::kNone;
  store.budget_bytes = options_.budget_bytes / 2;
  const std::optional<std::string> memory = memory_backend(backends_);
  const bool in_memory = memory && recomputation_.level_bytes <= store.budget_bytes;
  // On disk by the store's own backend: the one that is known to work here.
  if (in_memory) store.backend = *memory;
  Store made =
      Store::create(in_memory ? std::filesystem::path() : scratch_.directory().path() / "levels",
                    check_.base, store, backends_);
  recomputation_.make(made, options_.threads, [this](std::uint64_t done, std::uint64_t total) {
    return !options_.proceed || options_.proceed("compute anew", done, total);
  });
  check_attributes(made);
  made_.emplace(std::move(made));
  return *made_;
}

void RecomputedStore::check_attributes(const Store& made) const {
  for (const AttributeInfo& expected : check_.attributes) {
    const std::string& name = expected.schema.name;
    if (!refusal(name).empty()) continue;
    const AttributeInfo* const found =
        made.has_attribute(name) ? &made.attributes()[made.attribute(name)] : nullptr;
    if (found == nullptr || found->schema != expected.schema ||
        found->finest_level != expected.finest_level)
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("repair: the recomputation promised attribute '{}' and made {}", name,
                              found == nullptr ? "none of this name"
                                               : "one of another type or finest level"));
  }
}

PLAIT_END_NAMESPACE
