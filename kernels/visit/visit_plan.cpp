#include "plait/detail/visit_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <span>
#include <utility>

#include "base/default_arithmetic.h"
#include "base/threads.h"
#include "paging/level_cursor.h"
#include "plait/detail/ring_table.h"
#include "plait/error.h"
#include "plait/extend/base_relative_level.h"
#include "plait/extend/edge_index.h"
#include "plait/extend/pager.h"
#include "plait/extend/store_access.h"
#include "plait/progress.h"

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
                     std::vector<VisitedAttribute> attributes, int first_level)
    : store_(&store),
      options_(&options),
      threads_(thread_count(options.threads, fmt::format("visit '{}'", options.name))),
      attributes_(std::move(attributes)),
      mesh_(store.base().topology()),
      depths_(store.base().depths()) {
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
  if (first_level > level_)
    refuse_visit(options, ErrorCode::kInvalidArgument,
                 fmt::format("levels {} to {}: expected a first level of {} or less", first_level,
                             level_, level_));
  for (const VisitedAttribute& attribute : attributes_) {
    const int finest = store.attributes()[attribute.id].finest_level;
    if (level_ > finest)
      refuse_visit(options, ErrorCode::kInvalidArgument,
                   fmt::format("level {}, but attribute '{}' ends at level {}: make it with "
                               "Store::add_attribute(schema, {})",
                               level_, attribute.name, finest, level_));
  }
  refinements_ = relative_to_base(level_, first).refinements;
  first_refinement_ = first_level - first;
  // Of the whole level also in the store of one part: runs have the numbers that the store gives.
  for (int level = first + 1; level <= level_; ++level)
    numbers_.push_back(
        store.base().geometry(relative_to_base(level, first), 1, store.options().block_bytes));
  own_vertices_ = StoreAccess::own_vertices(store);
  if (reads_rings_ && depths_ != nullptr) find_ring_depths();
  choose_threads();
}

std::uint64_t VisitPlan::grid_bytes() const {
  if (refinements_ == 0) return 0;
  const std::uint64_t points = GridShape(refinements_).point_count() + 1;  // see EdgeGrid
  std::uint64_t bytes = 0;
  for (const VisitedAttribute& attribute : attributes_)
    if (attribute.rings) bytes += component_bytes(attribute.type) * attribute.components * points;
  return bytes;
}

void VisitPlan::choose_threads() {
  const std::uint64_t grids = grid_bytes();
  const std::uint64_t budget = StoreAccess::pager(*store_).budget_bytes();
  while (threads_ > 1) {
    lent_bytes_ = static_cast<std::uint64_t>(threads_ - 1) * grids;
    if (sweep_window_bytes(*store_, pass(), threads_) + lent_bytes_ <= budget) return;
    threads_ = fewer_threads(threads_);
  }
  lent_bytes_ = 0;
}

void VisitPlan::find_ring_depths() {
  ring_depths_.assign(mesh_.vertex_corners.size(), static_cast<std::uint8_t>(refinements_));
  for (FaceId face = 0; face < mesh_.faces.size(); ++face)
    for (const VertexId vertex : mesh_.faces[face])
      ring_depths_[vertex] =
          static_cast<std::uint8_t>(std::min<int>(ring_depths_[vertex], depths_->of(face)));
}

void VisitPlan::for_each_outer_spoke(
    std::size_t number,
    const std::function<void(EdgeId, const std::byte*, const std::byte*)>& visit) const {
  if (!own_vertices_) return;
  const EdgeRange own = StoreAccess::edges(*store_);
  std::vector<EdgeId> outer;
  for (const VertexId vertex : *own_vertices_)
    for_each_spoke(mesh_, vertex, [&](EdgeId edge) {
      if (edge < own.first || edge >= own.after) outer.push_back(edge);
    });
  std::ranges::sort(outer);
  outer.erase(std::unique(outer.begin(), outer.end()), outer.end());
  const VisitedAttribute& attribute = attributes_[number];
  const std::size_t record_bytes = component_bytes(attribute.type) * attribute.components;
  LevelCursor cursor(StoreAccess::open_session(*store_),
                     StoreAccess::level_file(std::as_const(*store_), attribute.id, level_));
  const std::int64_t last = slot_side(refinements_) - 1;
  for (const EdgeId edge : outer) {
    const LocatedSlot slot = cursor.slot(edge);
    const auto at = [&](std::int64_t row, std::int64_t column) {
      return slot.bytes.data() + record_bytes * static_cast<std::size_t>(slot_position(
                                                    refinements_, slot.shape, row, column));
    };
    // The point (row, column) of a slot is at (2 row + 1, 2 column + 1) of the grid of the edge,
    // which runs from (0, 2 last + 2) to (2 last + 2, 0): see EdgeGrid.
    visit(edge, at(last, 0), at(0, last));
  }
}

SweepPass VisitPlan::pass() const {
  SweepPass pass;
  pass.name = options_->name;
  for (const VisitedAttribute& attribute : attributes_)
    pass.accesses.push_back(
        {attribute.id, store_->base_level() + (attribute.rings ? 1 : first_refinement()), level_,
         attribute.access, attribute.rings ? Reach::kFaces : Reach::kOwn});
  return pass;
}

std::span<std::byte> VisitPlan::base_bytes(std::size_t number) const {
  const VisitedAttribute& attribute = attributes_[number];
  if (attribute.access != Access::kRead && visits_base())
    return StoreAccess::base_bytes(*store_, attribute.id, attribute.access);
  // Base records that are only read stay as they were committed.
  const std::span<const std::byte> read = std::as_const(*store_).base_bytes(attribute.id);
  return {const_cast<std::byte*>(read.data()), read.size()};
}

Needs VisitPlan::needs() const {
  Needs needs{sweep_window_bytes(*store_, pass(), threads_), ring_depths_.size()};
  needs.resident += grid_bytes();
  for (const VisitedAttribute& attribute : attributes_)
    if (attribute.rings)
      needs.resident +=
          component_bytes(attribute.type) * attribute.components * 2 * store_->base().edge_count();
  return needs;
}

std::uint64_t VisitPlan::base_vertices() const {
  if (!visits_base()) return 0;
  return own_vertices_ ? own_vertices_->size() : store_->base().vertex_count();
}

std::uint64_t VisitPlan::vertices_before(std::uint64_t edge) const {
  const EdgeId first = StoreAccess::edges(*store_).first;
  std::uint64_t vertices = 0;
  for (const LevelGeometry& level :
       std::span(numbers_).subspan(static_cast<std::size_t>(first_refinement() - 1)))
    vertices += (edge < level.edge_count() ? level.slot(static_cast<EdgeId>(edge)).offset
                                           : level.total_bytes()) -
                level.slot(first).offset;
  return vertices;
}

void VisitPlan::run(const std::function<void(const SweepView&, EdgeId, int)>& edge_kernel,
                    const std::function<void()>& base_kernel,
                    const std::function<void()>& stretch_done) const try {
  if (options_->begins) options_->begins(threads_);
  const LentMemory lent(StoreAccess::pager(*store_), lent_bytes_);
  const EdgeRange edges = StoreAccess::edges(*store_);
  const std::uint64_t total = vertices_before(edges.after) + base_vertices();
  // Levels and base records from the first edge to the last base vertex.
  UnfinishedLevels written;
  const auto begin = [&] {
    for (const VisitedAttribute& attribute : attributes_) {
      if (visits_base())
        written.add_base(StoreAccess::base_records_of(*store_, attribute.id), attribute.access);
      for (int level = store_->base_level() + first_refinement(); level <= level_; ++level)
        written.add(StoreAccess::level_file(*store_, attribute.id, level), attribute.access);
    }
  };
  if (refinements_ > 0) {
    SweepPass sweep_pass = pass();
    sweep_pass.kernel = edge_kernel;
    sweep_pass.stretch_done = stretch_done;
    SweepOptions options;
    options.threads = threads_;
    options.begins = begin;
    options.takes_depths = true;
    if (options_->progress)
      options.progress = [&](const Progress& now) {
        return options_->progress({options_->name, vertices_before(edges.first + now.done), total});
      };
    sweep(*store_, sweep_pass, options);
  }
  // Refuses base records from which a block of the sweep was encoded meanwhile.
  for (std::size_t number = 0; refinements_ > 0 && number < attributes_.size(); ++number)
    if (attributes_[number].access != Access::kRead)
      static_cast<void>(
          StoreAccess::base_bytes(*store_, attributes_[number].id, Access::kOverwrite));
  std::optional<StorePass> under_way;
  if (std::ranges::any_of(attributes_,
                          [](const auto& each) { return each.access != Access::kRead; }))
    under_way.emplace(*store_, fmt::format("visit '{}' of", options_->name));
  else
    under_way.emplace(std::as_const(*store_));
  if (refinements_ == 0) begin();
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
