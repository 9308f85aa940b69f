// plait/kernels/visit_plan.h: the part of visit_vertices() that does not depend on the types of
// records. Programs use plait/kernels/visit_vertices.h.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "plait/attribute.h"
#include "plait/kernels/vertex_rings.h"
#include "plait/level_geometry.h"
#include "plait/namespace.h"
#include "plait/store.h"
#include "plait/sweep.h"

PLAIT_BEGIN_NAMESPACE

/// How far a visit goes, by how many threads, and who watches it.
struct VisitOptions {
  std::string name = "visit";  ///< for errors
  /// Visits the vertices of levels 0 to `level`. -1: the finest level of the attributes, which must
  /// then have equally many levels.
  int level = -1;
  int threads = 1;  ///< 1 to 1024
  /// Called between blocks on the calling thread. False ends the visit with kCancelled; the levels
  /// that it writes then stay unfinished. The last call has vertices_done == vertices_total, and
  /// its result does not matter.
  std::function<bool(std::uint64_t vertices_done, std::uint64_t vertices_total)> proceed = {};
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
  int threads() const noexcept { return options_->threads; }
  /// How often the base mesh is refined to reach the finest level of the visit.
  int refinements() const noexcept { return refinements_; }
  /// Whether the visit reads the rings of any attribute.
  bool reads_rings() const noexcept { return reads_rings_; }
  /// The run of all vertices of a slot. `refinement` counts from the base mesh.
  VertexRun run_of(int refinement, EdgeId edge, int worker) const {
    const Slot slot = numbers_[static_cast<std::size_t>(refinement - 1)].slot(edge);
    return {level_number(BaseRelativeLevel(refinement), store_->base_level()), slot.offset,
            static_cast<std::size_t>(slot.bytes), edge, worker};
  }

  VisitNeeds needs() const;
  /// Calls edge_kernel(view, edge, worker) for each edge, from several threads, and then
  /// base_kernel(). The accesses of the view are in the order of the attributes.
  void run(const std::function<void(const SweepView&, EdgeId, int)>& edge_kernel,
           const std::function<void()>& base_kernel) const;

 private:
  SweepPass pass() const;
  std::uint64_t vertices_before(EdgeId edge) const;

  Store* store_;
  const VisitOptions* options_;
  std::vector<VisitedAttribute> attributes_;
  int level_ = 0, refinements_ = 0;
  bool reads_rings_ = false;
  std::vector<LevelGeometry> numbers_;  ///< [refinement - 1] as if records had one byte
};

PLAIT_END_NAMESPACE
