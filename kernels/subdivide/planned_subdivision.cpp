#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <new>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/threads.h"
#include "plait/error.h"
#include "plait/extend/fused.h"
#include "plait/extend/store_access.h"
#include "plait/layout.h"
#include "plait/subdivide.h"
#include "schemes/table.h"
#include "store/base_positions.h"
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
  if (!store.has_attribute("normal")) return;
  const AttributeSchema& normal = store.attributes()[store.attribute("normal")].schema;
  if (const AttributeSchema ours = schema_of<Vector3<float>>("normal");
      options.normals && (normal.type != ours.type || normal.components != ours.components))
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("subdivide: expected attribute 'normal' to be {} x {}, because new "
                            "normals take its place, found {} x {}: remove it, or give it another "
                            "name",
                            to_string(ours.type), ours.components, to_string(normal.type),
                            normal.components));
  if (!options.normals &&
      (options.limit || options.levels > store.attributes()[position].finest_level))
    throw Error(
        ErrorCode::kInvalidArgument,
        "subdivide: the store has normals, which do not fit a finer level: ask for normals, so "
        "that new ones are computed");
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

PlannedSubdivision plan_subdivision(Store& store, const SubdivideOptions& options) {
  return {store, options};
}

PlannedSubdivision::PlannedSubdivision(Store& store, const SubdivideOptions& options)
    : store_(&store),
      options_(options),
      position_(position_of(store, "subdivide")),
      wanted_threads_(thread_count(options.threads, "subdivide")),
      first_level_(store.attributes()[position_].finest_level) {
  const AttributeSchema& schema = store.attributes()[position_].schema;
  provenance_ = provenance_after(store, options, first_level_, schema.type);
  check_numbers(store, options);
  check_attributes(store, options, position_);
  if (makes_levels()) StoreAccess::refuse_depths(store, "subdivide", options.levels);
  StoreAccess::check_changeable(store, "subdivide");
  choose_executor();
  const bool moves_even = makes_levels() && traits_of(options.scheme).moves_even;
  if (moves_even)
    for (int level = store.base_level() + 1; level <= first_level_; ++level)
      check_not_fixed(StoreAccess::level_file(store, position_, level));
  if (options.limit || moves_even)
    // Refuses records that other blocks are encoded from.
    StoreAccess::begin_base_change(store, position_, Access::kUpdate);
}

void PlannedSubdivision::take(ExecutorKind executor) {
  options_.executor = executor;
  frame_budget_ = frame_budget();
  const int wanted = executor == ExecutorKind::kTransparent ? 1 : wanted_threads_;
  for (int threads = wanted;; threads = fewer_threads(threads)) {
    options_.threads = threads;
    frame_bytes_ = frames_of_subdivision(*store_, options_, makes_levels());
    lent_bytes_ = threads == 1 ? 0 : scratch_bytes(threads) - scratch_bytes(1);
    if (threads == 1 || frame_bytes_ + lent_bytes_ <= frame_budget_) return;
  }
}

std::uint64_t PlannedSubdivision::scratch_bytes(int threads) const {
  SubdivideOptions options = options_;
  options.threads = threads;
  return resident_of_subdivision(*store_, options);
}

void PlannedSubdivision::choose_executor() {
  const int base_level = store_->base_level(), levels = options_.levels - base_level;
  const ExecutorKind wanted = options_.executor;
  if (wanted == ExecutorKind::kAuto) {
    if (first_level_ == base_level && !options_.level_done && levels > 0 &&
        levels <= kMostFusedLevels) {
      take(ExecutorKind::kFused);
      if (frame_bytes_ <= frame_budget_) return;
    }
    return take(ExecutorKind::kSweep);
  }
  // The fused executor makes levels. Normals of base vertices alone are a sweep's work.
  if (wanted != ExecutorKind::kFused || levels == 0)
    return take(wanted == ExecutorKind::kFused ? ExecutorKind::kSweep : wanted);
  if (first_level_ > base_level)
    throw Error(ErrorCode::kNotSupported,
                fmt::format("subdivide: the fused executor starts at the base mesh, and the "
                            "store has level {}: take sweep",
                            first_level_));
  if (levels > kMostFusedLevels)
    throw Error(ErrorCode::kNotSupported,
                fmt::format("subdivide: {} levels over the store's base mesh, expected at most {} "
                            "with the fused executor: take another one, or a finer base mesh",
                            levels, kMostFusedLevels));
  take(wanted);
}

/// What the levels of the whole work leave of the budget for frames.
std::uint64_t PlannedSubdivision::frame_budget() const {
  const AttributeSchema& position = store_->attributes()[position_].schema;
  const bool is_fused = options_.executor == ExecutorKind::kFused;
  const int first = store_->base_level() + 1, last = options_.levels;
  std::vector<StoreAccess::NewLevels> made = {{position, position_, first_level_ + 1, last}};
  if (options_.normals) made.push_back({schema_of<Vector3<float>>("normal"), kNoId, first, last});
  if (options_.limit && !is_fused) made.push_back({position, kNoId, first, last});
  Provenance provenance = provenance_;
  provenance.limit = is_fused && options_.limit;
  return StoreAccess::frame_budget_with(*store_, made, is_fused ? &provenance : nullptr);
}

Needs PlannedSubdivision::needs() const { return {frame_bytes_, scratch_bytes(1)}; }

void PlannedSubdivision::check_budget() const {
  if (frame_bytes_ <= frame_budget_) return;
  const std::uint64_t budget = store_->options().budget_bytes;
  // What a backend keeps for itself grows with the budget, to a quarter of it.
  std::uint64_t needed = frame_bytes_;
  if (!StoreAccess::backend_traits(*store_).in_memory &&
      (frame_budget_ < budget || store_->finest_level() == store_->base_level()))
    needed = std::max(frame_bytes_ + (budget - frame_budget_), (4 * frame_bytes_ + 2) / 3);
  throw Error(
      ErrorCode::kBudget,
      fmt::format("subdivide to level {}: the whole work needs a budget of {} bytes, found {}; the "
                  "layout '{}' has stencils that span {} edges, and a block holds {} bytes: raise "
                  "the budget, take smaller blocks or another layout",
                  options_.levels, needed, budget, store_->provenance().layout,
                  measure_spans(store_->base()).loop.span, store_->options().block_bytes));
}

PLAIT_END_NAMESPACE
