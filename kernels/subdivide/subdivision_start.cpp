#include "subdivide/subdivision_start.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "plait/error.h"
#include "plait/extend/base_relative_level.h"
#include "plait/extend/fused.h"
#include "plait/extend/store_access.h"
#include "plait/layout.h"
#include "schemes/table.h"
#include "subdivide/steps.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

void check_numbers(const Store& store, const SubdivideOptions& options) {
  if (options.levels < store.base_level() || options.levels > kMaxLevel)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("subdivide to level {}: expected {} to {}", options.levels,
                            store.base_level(), kMaxLevel));
  if (const SchemeTraits scheme = traits_of(options.scheme); options.limit && !scheme.has_limits)
    throw Error(ErrorCode::kNotSupported,
                fmt::format("subdivide: scheme {} has no limit positions", scheme.name));
}

void check_attributes(const Store& store, const SubdivideOptions& options, AttributeId position) {
  for (const std::string_view name : {"position", "normal"})
    if (const std::string replacement = StoreAccess::name_until_named(name);
        store.has_attribute(replacement))
      throw Error(ErrorCode::kBadState,
                  fmt::format("subdivide: an earlier call has ended early and left '{}': take "
                              "Store::roll_back() first",
                              replacement));
  for (int level = store.base_level(); level <= store.attributes()[position].finest_level; ++level)
    StoreAccess::check_readable(store, position, level);
  if (store.has_attribute("normal") && !options.normals)
    throw Error(
        ErrorCode::kInvalidArgument,
        "subdivide: the store has normals, which do not fit a finer level: ask for normals, so "
        "that new ones are computed");
}

/// Throws kBudget for a subdivision whose whole work needs `frame_bytes`, of `found` bytes that its
/// levels leave of the budget.
[[noreturn]] void refuse_budget(const Store& store, const SubdivideOptions& options,
                                std::uint64_t frame_bytes, std::uint64_t found) {
  const std::uint64_t budget = store.options().budget_bytes;
  // What a backend keeps for itself grows with the budget, to a quarter of it.
  std::uint64_t needed = frame_bytes;
  if (!StoreAccess::backend_traits(store).in_memory &&
      (found < budget || store.finest_level() == store.base_level()))
    needed = std::max(frame_bytes + (budget - found), (4 * frame_bytes + 2) / 3);
  throw Error(
      ErrorCode::kBudget,
      fmt::format("subdivide to level {}: the whole work needs a budget of {} bytes, found {}; the "
                  "layout '{}' has stencils that span {} edges, and a block holds {} bytes: raise "
                  "the budget, take smaller blocks, fewer threads or another layout",
                  options.levels, needed, budget, store.provenance().layout,
                  measure_spans(store.base()).loop.span, store.options().block_bytes));
}

/// How the levels are made. If the existing ones are limit positions or were made by another
/// scheme, this scheme alone would not have made them, so the provenance names none.
Provenance provenance_after(const Store& store, const SubdivideOptions& options, int level,
                            ComponentType precision) {
  Provenance provenance = store.provenance();
  const std::string_view scheme = traits_of(options.scheme).name;
  if (level != store.base_level() && (provenance.scheme != scheme || provenance.limit))
    provenance.scheme.clear();
  else
    provenance.scheme = scheme;
  provenance.limit = false;
  provenance.precision = precision;
  provenance.program = program_version();
  return provenance;
}

}  // namespace

SubdivisionStart::SubdivisionStart(Store& store, const SubdivideOptions& options)
    : store_(store),
      options_(with_threads(options)),
      position_(store.attribute("position")),
      level_(store.attributes()[position_].finest_level),
      provenance_(
          provenance_after(store, options, level_, store.attributes()[position_].schema.type)) {
  check_numbers(store, options);
  check_attributes(store, options, position_);
  StoreAccess::check_changeable(store, "subdivide");
  options_.executor = executor_for(store, options_);
  check_executor();
  const bool makes_levels = options.levels > level_,
             moves_even = makes_levels && traits_of(options.scheme).moves_even;
  if (moves_even)
    for (int level = store.base_level() + 1; level <= level_; ++level)
      check_not_fixed(StoreAccess::level_file(store, position_, level));
  check_budget();
  if (options.limit || moves_even)
    store.base_bytes(position_);  // refuses records that other blocks are encoded from
}

void SubdivisionStart::check_executor() const {
  if (!is_fused()) return;
  const int base_level = store_.base_level();
  if (level_ > base_level && options_.levels > base_level)
    throw Error(ErrorCode::kNotSupported,
                fmt::format("subdivide: the fused executor starts at the base mesh, and the "
                            "store has level {}: take sweep",
                            level_));
  if (options_.levels - base_level > kMostFusedLevels)
    throw Error(ErrorCode::kNotSupported,
                fmt::format("subdivide: {} levels over the store's base mesh, expected at most {} "
                            "with the fused executor: take another one, or a finer base mesh",
                            options_.levels - base_level, kMostFusedLevels));
}

std::vector<StoreAccess::NewLevels> SubdivisionStart::surface() const {
  const int first = store_.base_level() + 1;
  std::vector<StoreAccess::NewLevels> made;
  if (options_.normals)
    made.push_back({schema_of<Vector3<float>>("normal"), kNoId, first, options_.levels});
  if (options_.limit && !is_fused())
    made.push_back({store_.attributes()[position_].schema, kNoId, first, options_.levels});
  return made;
}

void SubdivisionStart::check_budget() const {
  std::uint64_t needed = 0;
  if (is_fused()) {
    const std::array<std::size_t, 2> records = {
        store_.attributes()[position_].schema.record_bytes(), sizeof(Vector3<float>)};
    if (options_.levels > store_.base_level())
      needed = fused_frame_bytes(store_, std::span(records).first(options_.normals ? 2 : 1),
                                 options_.levels, options_.threads);
  } else {
    needed = subdivide_frame_bytes(store_, options_);
  }
  if (const std::uint64_t found = frame_budget(); needed > found)
    refuse_budget(store_, options_, needed, found);
}

/// What the levels of the whole work leave of the budget for frames.
std::uint64_t SubdivisionStart::frame_budget() const {
  std::vector<StoreAccess::NewLevels> made = surface();
  made.insert(made.begin(), StoreAccess::NewLevels{store_.attributes()[position_].schema, position_,
                                                   level_ + 1, options_.levels});
  Provenance provenance = provenance_;
  provenance.limit = is_fused() && options_.limit;
  return StoreAccess::frame_budget_with(store_, made, is_fused() ? &provenance : nullptr);
}

PLAIT_END_NAMESPACE
