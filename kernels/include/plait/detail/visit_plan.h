// plait/detail/visit_plan.h: the part of visit_vertices() that does not depend on the types of
// records. Programs use plait/visit_vertices.h.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "plait/attribute.h"
#include "plait/detail/namespace.h"
#include "plait/detail/vertex_rings.h"
#include "plait/extend/level_geometry.h"
#include "plait/extend/sweep.h"
#include "plait/progress.h"
#include "plait/store.h"

PLAIT_BEGIN_NAMESPACE

/// How far a visit goes, by how many threads, and who watches it.
struct VisitOptions {
  std::string name = "visit";  ///< for errors
  /// Visits the vertices of levels 0 to `level`. -1: the finest level of the attributes, which must
  /// then have equally many levels.
  int level = -1;
  int threads = 1;  ///< 1 to 1024; 0: all processors
  /// Counts vertices; called between blocks. Levels that a cancelled visit writes stay unfinished.
  /// The last call has done == total, and its result does not matter.
  ProgressCallback progress = {};
};

/// The memory that a visit needs.
struct VisitNeeds {
  std::uint64_t frame_bytes = 0;  ///< of the pager's budget: the smallest budget for the visit
  /// In addition to the budget: for each attribute whose rings it reads, the grid of an edge for
  /// each thread, and two records for each base edge.
  std::uint64_t ring_bytes = 0;
};

/// One attribute of a visit.
struct VisitedAttribute {
  std::string_view name;
  ComponentType type;
  std::uint32_t components;
  Access access;
  bool rings;
  AttributeId id = 0;  ///< filled in by VisitPlan
};

/// For one thread.
class VisitPlan {
 public:
  /// Errors: kNotFound for an attribute that the store does not have; kInvalidArgument for other
  /// records than those of the attribute, for an attribute that is named twice, for levels that an
  /// attribute does not have, and for a number of threads out of range; kBadState for writing to a
  /// store that was opened for reading.
  VisitPlan(Store& store, const VisitOptions& options, std::vector<VisitedAttribute> attributes);

  Store& store() const noexcept { return *store_; }
  AttributeId attribute(std::size_t number) const { return attributes_[number].id; }
  int threads() const noexcept { return threads_; }
  /// How often the base mesh is refined to reach the finest level of the visit.
  int refinements() const noexcept { return refinements_; }
  /// Whether the visit reads the rings of any attribute.
  bool reads_rings() const noexcept { return reads_rings_; }
  /// The run of all vertices of a slot. `refinement` counts from the base mesh.
  VertexRun run_of(int refinement, EdgeId edge, int worker) const {
    const Slot slot = numbers_[static_cast<std::size_t>(refinement - 1)].slot(edge);
    VertexRun run;
    run.level = level_number(BaseRelativeLevel(refinement), store_->base_level());
    run.first = slot.offset;
    run.count = static_cast<std::size_t>(slot.bytes);
    run.edge = edge;
    run.worker = worker;
    run.mesh_ = &mesh_;
    run.refinement_ = refinement;
    run.first_of_slot_ = slot.offset;
    run.shape_ = slot.shape;
    return run;
  }
  /// A run of base vertices.
  VertexRun base_run(std::size_t count) const {
    VertexRun run;
    run.level = store_->base_level();
    run.count = count;
    run.mesh_ = &mesh_;
    return run;
  }

  SlotShape shape_of(int refinement, EdgeId edge) const {
    return numbers_[static_cast<std::size_t>(refinement - 1)].slot(edge).shape;
  }

  VisitNeeds needs() const;
  /// Calls edge_kernel(view, edge, worker) for each edge, from several threads, and then
  /// base_kernel(). The accesses of the view are in the order of the attributes. `stretch_done` is
  /// that of SweepPass.
  void run(const std::function<void(const SweepView&, EdgeId, int)>& edge_kernel,
           const std::function<void()>& base_kernel,
           const std::function<void()>& stretch_done = {}) const;

 private:
  SweepPass pass() const;
  std::uint64_t vertices_before(EdgeId edge) const;

  Store* store_;
  const VisitOptions* options_;
  int threads_ = 1;
  std::vector<VisitedAttribute> attributes_;
  Topology mesh_;
  int level_ = 0, refinements_ = 0;
  bool reads_rings_ = false;
  std::vector<LevelGeometry> numbers_;  ///< [refinement - 1] as if records had one byte
};

PLAIT_END_NAMESPACE
