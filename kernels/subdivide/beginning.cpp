#include "subdivide/beginning.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "plait/error.h"
#include "plait/extend/base_relative_level.h"
#include "plait/extend/edge_index.h"
#include "plait/extend/fused.h"
#include "plait/extend/store_access.h"
#include "plait/layout.h"
#include "schemes/table.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr std::string_view kNewNormals = "normal_anew", kLimits = "limit", kNormals = "normal";

/// The first unfinished level of an attribute, or one beyond the finest level.
int first_unfinished(const Store& store, AttributeId id) {
  const int finest = store.attributes()[id].finest_level;
  for (int level = store.base_level() + 1; level <= finest; ++level)
    if (!StoreAccess::level_file(store, id, level).is_finished()) return level;
  return finest + 1;
}

/// Whether the store has the attribute, and an earlier call left it unfinished.
bool is_left_over(const Store& store, std::string_view name) {
  if (!store.has_attribute(name)) return false;
  const AttributeId id = store.attribute(name);
  return first_unfinished(store, id) <= store.attributes()[id].finest_level;
}

bool stays(const Store& store, std::string_view name) {
  return store.has_attribute(name) && !is_left_over(store, name);
}

void check_numbers(const Store& store, const SubdivideOptions& options) {
  if (options.levels < store.base_level() || options.levels > kMaxLevel)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("subdivide to level {}: expected {} to {}", options.levels,
                            store.base_level(), kMaxLevel));
  if (const SchemeTraits scheme = traits_of(options.scheme); options.limit && !scheme.has_limits)
    throw Error(ErrorCode::kNotSupported,
                fmt::format("subdivide: scheme {} has no limit positions", scheme.name));
}

void check_attributes(const Store& store, const SubdivideOptions& options) {
  if (stays(store, kLimits))
    throw Error(ErrorCode::kInvalidArgument,
                "subdivide: the store has an attribute 'limit' already");
  if (options.normals && stays(store, kNewNormals))
    throw Error(ErrorCode::kInvalidArgument,
                "subdivide: the store has an attribute 'normal_anew' already");
  if (store.has_attribute(kNormals) && !options.normals)
    throw Error(
        ErrorCode::kInvalidArgument,
        "subdivide: the store has normals, which do not fit a finer level: ask for normals, so "
        "that new ones are computed");
}

}  // namespace

int finest_kept_level(const Store& store, const Scheme& scheme) {
  const AttributeId position = store.attribute("position");
  const int unfinished = first_unfinished(store, position);
  if (unfinished > store.attributes()[position].finest_level) return unfinished - 1;
  return traits_of(scheme).moves_even ? store.base_level() : unfinished - 1;
}

Beginning::Beginning(Store& store, const SubdivideOptions& options)
    : store_(store),
      options_(options),
      level_(finest_kept_level(store, options.scheme)),
      there_(store.attributes()[position()].finest_level),
      sequence_(store.sequence()),
      provenance_(store.provenance()) {
  check_numbers(store, options);
  check_attributes(store, options);
  StoreAccess::check_changeable(store, "subdivide");
  const ExecutorKind executor = executor_for(store, options);
  if (executor == ExecutorKind::kFused && level_ > store.base_level() &&
      options.levels > store.base_level())
    throw Error(ErrorCode::kNotSupported,
                fmt::format("subdivide: the fused executor starts at the base mesh, and the "
                            "store has level {}: take sweep",
                            level_));
  if (executor == ExecutorKind::kFused && options.levels - store.base_level() > kMostFusedLevels)
    throw Error(ErrorCode::kNotSupported,
                fmt::format("subdivide: {} levels over the store's base mesh, expected at most {} "
                            "with the fused executor: take another one, or a finer base mesh",
                            options.levels - store.base_level(), kMostFusedLevels));
  const bool restarts = level_ < there_;
  if (restarts && level_ == store.base_level() && records_before_levels().empty())
    throw Error(ErrorCode::kBadState,
                fmt::format("subdivide: level {} of 'position' is unfinished, and the base records "
                            "from which the levels were made are not known: take "
                            "Store::roll_back() first",
                            first_unfinished(store, position())));
  if (traits_of(options.scheme).moves_even && options.levels > level_)
    for (int level = store.base_level() + 1; level <= level_; ++level)
      check_not_fixed(StoreAccess::level_file(store, position(), level));
  if (executor == ExecutorKind::kFused || traits_of(options.scheme).moves_even) check_pipelines();
  check_budget();
  before_levels_ = std::exchange(records_before_levels(), {});
  try {
    if (options.limit || (traits_of(options.scheme).moves_even && options.levels > level_))
      store.base_bytes(position());  // refuses records that other blocks are encoded from
  } catch (...) {
    records_before_levels() = std::move(before_levels_);
    throw;
  }
  const std::span<const std::byte> records = std::as_const(store).base_bytes(position());
  records_.assign(records.begin(), records.end());
  const bool same_scheme =
      provenance_.scheme == traits_of(options.scheme).name && !provenance_.limit;
  if (level_ == store.base_level()) {
    if (!restarts) before_levels_ = records_;
  } else if (!same_scheme) {
    before_levels_.clear();
  }
}

void Beginning::check_pipelines() const {
  for (int level = level_ + 1; level <= options_.levels; ++level)
    if (StoreAccess::is_encoded_from_others(store_, position(), level))
      throw Error(ErrorCode::kBadState,
                  fmt::format("subdivide to level {}: blocks of level {} of 'position' would be "
                              "encoded from coarser vertices, which this work still changes: "
                              "subdivide with a pipeline without prediction (fast), then encode "
                              "the attribute anew (recode_attribute, plait convert --compress)",
                              options_.levels, level));
}

std::vector<std::byte>& Beginning::records_before_levels() const {
  return StoreAccess::records_before_levels(store_, position());
}

void Beginning::clear_away() {
  for (const std::string_view name : {kLimits, kNewNormals, kNormals})
    if (is_left_over(store_, name)) store_.remove_attribute(store_.attribute(name));
  if (level_ == there_) return;
  StoreAccess::remove_levels(store_, position(), level_);
  if (level_ == store_.base_level()) set_base_records(before_levels_);
}

void Beginning::set_base_records(const std::vector<std::byte>& records) {
  if (!std::ranges::equal(std::as_const(store_).base_bytes(position()), records))
    std::ranges::copy(records, store_.base_bytes(position()).begin());
}

void Beginning::check_budget() const {
  std::uint64_t needed = 0;
  if (executor_for(store_, options_) == ExecutorKind::kFused) {
    const std::array<std::size_t, 2> records = {
        store_.attributes()[position()].schema.record_bytes(), sizeof(Vector3<float>)};
    if (options_.levels > store_.base_level())
      needed = fused_frame_bytes(store_, std::span(records).first(options_.normals ? 2 : 1),
                                 options_.levels, options_.threads);
  } else {
    needed = subdivide_frame_bytes(store_, options_);
  }
  if (needed > std::as_const(StoreAccess::pager(store_)).budget_bytes())
    refuse_budget(store_, options_, needed, "");
}

AttributeId Beginning::add(const AttributeSchema& schema) {
  const AttributeId id = store_.add_attribute(schema);
  added_.push_back(schema.name);
  return id;
}

void Beginning::undo(bool everything) noexcept {
  try {
    // Levels that another level has moved, and what a callback has committed, cannot be undone.
    const bool undoes = everything && store_.sequence() == sequence_ &&
                        (level_ == store_.base_level() || !traits_of(options_.scheme).moves_even);
    for (const std::string& name : added_)
      if (store_.has_attribute(name) && (undoes || !is_left_over(store_, name)))
        store_.remove_attribute(store_.attribute(name));
    if (undoes) {
      StoreAccess::remove_levels(store_, position(), level_);
      StoreAccess::set_provenance(store_, provenance_);
    }
    // Levels that are complete have base records of their own.
    if (undoes || is_left_over(store_, "position"))
      set_base_records(level_ == store_.base_level() ? before_levels_ : records_);
    records_before_levels() = std::move(before_levels_);
  } catch (const std::exception&) {  // the levels stay unfinished, and nobody can read them
  }
}

void Beginning::finish(bool limit) noexcept {
  if (!limit) records_before_levels() = std::move(before_levels_);
}

void refuse_budget(const Store& store, const SubdivideOptions& options, std::uint64_t frame_bytes,
                   const char* reason) {
  const std::uint64_t budget = store.options().budget_bytes,
                      frames = StoreAccess::pager(store).budget_bytes();
  // What a backend keeps for itself grows with the budget, to a quarter of it.
  std::uint64_t needed = frame_bytes;
  if (!store.backend_traits().in_memory &&
      (frames < budget || store.finest_level() == store.base_level()))
    needed = std::max(frame_bytes + (budget - frames), (4 * frame_bytes + 2) / 3);
  throw Error(
      ErrorCode::kBudget,
      fmt::format("subdivide to level {}: the whole work needs a budget of {} bytes, found {}; the "
                  "layout '{}' has stencils that span {} edges, and a block holds {} bytes: raise "
                  "the budget, take smaller blocks, fewer threads or another layout{}{}",
                  options.levels, needed, budget, store.provenance().layout,
                  measure_spans(store.base()).loop.span, store.options().block_bytes,
                  *reason == 0 ? "" : "; ", reason));
}

PLAIT_END_NAMESPACE
