#include "plait/detail/visit_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "base/default_arithmetic.h"
#include "plait/error.h"
#include "plait/extend/base_relative_level.h"
#include "plait/extend/store_access.h"
#include "plait/extend/thread_count.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

[[noreturn]] void refuse_visit(const VisitOptions& options, ErrorCode code,
                               const std::string& what) {
  throw Error(code, fmt::format("visit '{}': {}", options.name, what));
}

/// The finest level of the attributes, if the caller gave none.
int finest_level_of(const Store& store, const VisitOptions& options,
                    const std::vector<VisitedAttribute>& attributes) {
  if (options.level >= 0 || attributes.empty())
    return options.level >= 0 ? options.level : store.base_level();
  const auto level_of = [&](const VisitedAttribute& attribute) {
    return store.attributes()[attribute.id].finest_level;
  };
  for (const VisitedAttribute& attribute : attributes)
    if (level_of(attribute) != level_of(attributes.front()))
      refuse_visit(options, ErrorCode::kInvalidArgument,
                   fmt::format("attribute '{}' has level {} and attribute '{}' has level {}: set "
                               "VisitOptions::level, or add the levels that are missing",
                               attributes.front().name, level_of(attributes.front()),
                               attribute.name, level_of(attribute)));
  return level_of(attributes.front());
}

}  // namespace

VisitPlan::VisitPlan(Store& store, const VisitOptions& options,
                     std::vector<VisitedAttribute> attributes)
    : store_(&store),
      options_(&options),
      threads_(thread_count(options.threads, fmt::format("visit '{}'", options.name))),
      attributes_(std::move(attributes)),
      mesh_(store.base().topology()) {
  for (std::size_t number = 0; number < attributes_.size(); ++number) {
    VisitedAttribute& attribute = attributes_[number];
    attribute.id = store.attribute(attribute.name);
    StoreAccess::check_type(store, attribute.id, attribute.type, attribute.components);
    reads_rings_ = reads_rings_ || attribute.rings;
    for (std::size_t other = 0; other < number; ++other)
      if (attributes_[other].id == attribute.id)
        refuse_visit(
            options, ErrorCode::kInvalidArgument,
            fmt::format("attribute '{}' is named twice: a pass that reads rings of an attribute "
                        "writes to another one",
                        attribute.name));
  }
  level_ = finest_level_of(store, options, attributes_);
  const int first = store.base_level();
  if (level_ < first)
    refuse_visit(
        options, ErrorCode::kInvalidArgument,
        fmt::format("level {}, expected {} or more: the base mesh of the store is level {}", level_,
                    first, first));
  for (const VisitedAttribute& attribute : attributes_) {
    const int finest = store.attributes()[attribute.id].finest_level;
    if (level_ > finest)
      refuse_visit(options, ErrorCode::kInvalidArgument,
                   fmt::format("level {}, but attribute '{}' ends at level {}: make it with "
                               "Store::add_attribute(schema, {})",
                               level_, attribute.name, finest, level_));
  }
  refinements_ = relative_to_base(level_, first).refinements;
  for (int level = first + 1; level <= level_; ++level)
    numbers_.push_back(StoreAccess::geometry(store, 1, level));
}

SweepPass VisitPlan::pass() const {
  SweepPass pass;
  pass.name = options_->name;
  for (const VisitedAttribute& attribute : attributes_)
    pass.accesses.push_back({attribute.id, store_->base_level() + 1, level_, attribute.access,
                             attribute.rings ? Reach::kFaces : Reach::kOwn});
  return pass;
}

VisitNeeds VisitPlan::needs() const {
  VisitNeeds needs;
  needs.frame_bytes = sweep_window_bytes(*store_, pass(), threads_);
  const std::uint64_t side = (std::uint64_t{1} << refinements_) + 3;  // see EdgeGrid
  const std::uint64_t grids =
      refinements_ > 0 ? static_cast<std::uint64_t>(threads_) * (side * side + 1) : 0;
  for (const VisitedAttribute& attribute : attributes_)
    if (attribute.rings)
      needs.ring_bytes += component_bytes(attribute.type) * attribute.components *
                          (grids + 2 * store_->base().edge_count());
  return needs;
}

std::uint64_t VisitPlan::vertices_before(EdgeId edge) const {
  std::uint64_t vertices = 0;
  for (const LevelGeometry& level : numbers_)
    vertices += edge < level.edge_count() ? level.slot(edge).offset : level.total_bytes();
  return vertices;
}

void VisitPlan::run(const std::function<void(const SweepView&, EdgeId, int)>& edge_kernel,
                    const std::function<void()>& base_kernel,
                    const std::function<void()>& stretch_done) const try {
  const std::uint64_t total = vertices_before(kNoId) + store_->base().vertex_count();
  if (refinements_ > 0) {
    SweepPass sweep_pass = pass();
    sweep_pass.kernel = edge_kernel;
    sweep_pass.stretch_done = stretch_done;
    SweepOptions options;
    options.threads = threads_;
    if (options_->progress)
      options.progress = [&](const Progress& now) {
        return options_->progress(
            {options_->name, vertices_before(static_cast<EdgeId>(now.done)), total});
      };
    sweep(*store_, sweep_pass, options);
  }
  // The sweep has finished the levels, but without the base vertices the pass is not complete.
  std::optional<StorePass> under_way;
  if (std::ranges::any_of(attributes_,
                          [](const auto& each) { return each.access != Access::kRead; }))
    under_way.emplace(*store_, fmt::format("visit '{}' of", options_->name));
  else
    under_way.emplace(std::as_const(*store_));
  UnfinishedLevels written;
  for (const VisitedAttribute& attribute : attributes_)
    for (int level = store_->base_level() + 1; level <= level_; ++level)
      written.add(StoreAccess::level_file(*store_, attribute.id, level), attribute.access);
  {
    const DefaultArithmetic arithmetic;
    base_kernel();
  }
  written.finish();
  if (options_->progress) options_->progress({options_->name, total, total});
} catch (const std::bad_alloc&) {
  throw out_of_memory("visit " + options_->name);
}

PLAIT_END_NAMESPACE
