#include "plait/kernels/visit_plan.h"

#include <fmt/format.h>

#include <utility>

#include "plait/base_relative_level.h"
#include "plait/error.h"

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
    : store_(&store), options_(&options), attributes_(std::move(attributes)) {
  if (options.threads < 1 || options.threads > 1024)
    refuse_visit(options, ErrorCode::kInvalidArgument,
                 fmt::format("{} threads, expected 1 to 1024", options.threads));
  for (std::size_t number = 0; number < attributes_.size(); ++number) {
    VisitedAttribute& attribute = attributes_[number];
    attribute.id = store.attribute(attribute.name);
    store.check_type(attribute.id, attribute.type, attribute.components);
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
  for (int refinement = 1; refinement <= refinements_; ++refinement)
    numbers_.emplace_back(store.base().slot_shapes(), BaseRelativeLevel(refinement), 1, 1);
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
  needs.frame_bytes = sweep_window_bytes(*store_, pass(), options_->threads);
  const std::uint64_t side = (std::uint64_t{1} << refinements_) + 3;  // see EdgeGrid
  const std::uint64_t grids =
      refinements_ > 0 ? static_cast<std::uint64_t>(options_->threads) * (side * side + 1) : 0;
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
                    const std::function<void()>& base_kernel) const {
  const std::uint64_t total = vertices_before(kNoId) + store_->base().vertex_count();
  if (refinements_ > 0) {
    SweepPass sweep_pass = pass();
    sweep_pass.kernel = edge_kernel;
    SweepOptions options;
    options.threads = options_->threads;
    if (options_->proceed)
      options.proceed = [&](std::uint64_t edges, std::uint64_t) {
        return options_->proceed(vertices_before(static_cast<EdgeId>(edges)), total);
      };
    sweep(*store_, sweep_pass, options);
  }
  // The sweep has finished the levels, but without the base vertices the pass is not complete.
  UnfinishedLevels written;
  for (const VisitedAttribute& attribute : attributes_)
    for (int level = store_->base_level() + 1; level <= level_; ++level)
      written.add(store_->level_file(attribute.id, level), attribute.access);
  base_kernel();
  written.finish();
  if (options_->proceed) options_->proceed(total, total);
}

PLAIT_END_NAMESPACE
