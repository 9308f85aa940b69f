// plait/detail/visit_plan.h: the part of visit_vertices() that does not depend on the types of
// records. Programs use plait/visit_vertices.h.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "plait/attribute.h"
#include "plait/detail/edge_grid.h"
#include "plait/detail/face_depths.h"
#include "plait/detail/namespace.h"
#include "plait/detail/ring_runs.h"
#include "plait/extend/level_geometry.h"
#include "plait/extend/sweep.h"
#include "plait/needs.h"
#include "plait/store.h"
#include "plait/vertex_rings.h"
#include "plait/visit_options.h"

PLAIT_BEGIN_NAMESPACE

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
  /// The visit leaves out levels that are coarser than `first_level`, also if it reads rings there.
  VisitPlan(Store& store, const VisitOptions& options, std::vector<VisitedAttribute> attributes,
            int first_level = 0);

  Store& store() const noexcept { return *store_; }
  AttributeId attribute(std::size_t number) const { return attributes_[number].id; }
  /// The base records of attribute `number`, to be used as the visit uses the attribute. Errors:
  /// those of Store::base_bytes.
  std::span<std::byte> base_bytes(std::size_t number) const;
  int threads() const noexcept { return threads_; }
  /// How often the base mesh is refined to reach the finest level of the visit.
  int refinements() const noexcept { return refinements_; }
  /// The first level over the base mesh that is visited, counted from the base mesh.
  int first_refinement() const noexcept { return std::max(1, first_refinement_); }
  bool visits_base() const noexcept { return first_refinement_ <= 0; }
  /// Whether the visit reads the rings of any attribute.
  bool reads_rings() const noexcept { return reads_rings_; }
  /// The run of all vertices of a slot; of none, if no face of the edge has the level. `refinement`
  /// counts from the base mesh.
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
    if (depths_ != nullptr && slot.shape == SlotShape::kHalf) [[unlikely]]
      run.is_of_other_face_ =
          !depths_->own_face_has(mesh_.edges[edge], BaseRelativeLevel(refinement));
    return run;
  }
  /// Calls visit(run) until each base vertex of the visit was in a run: all, but in the store of
  /// one part. Runs have one vertex if the visit reads rings, and otherwise as many as there are
  /// one after another.
  template <class Visit>
  void for_each_base_run(const Visit& visit) const {
    VertexRun run;
    run.level = store_->base_level();
    run.mesh_ = &mesh_;
    const std::uint64_t count = own_vertices_ ? own_vertices_->size() : mesh_.vertex_corners.size();
    const auto vertex = [&](std::uint64_t at) {
      return own_vertices_ ? (*own_vertices_)[static_cast<std::size_t>(at)] : at;
    };
    for (std::uint64_t at = 0; at < count; at += run.count) {
      run.first = vertex(at);
      run.count = 1;
      while (!reads_rings_ && at + run.count < count &&
             vertex(at + run.count) == run.first + run.count)
        ++run.count;
      visit(std::as_const(run));
    }
  }
  /// In the store of one part: calls visit(edge, next_to_start, next_to_end) for each edge at a
  /// base vertex of the part that the sweep does not visit, with the records of attribute `number`
  /// that are next to its ends at the finest level of the visit. REQUIRES: refinements() > 0.
  /// Errors: those of Session::pin.
  void for_each_outer_spoke(
      std::size_t number,
      const std::function<void(EdgeId, const std::byte*, const std::byte*)>& visit) const;

  SlotShape shape_of(int refinement, EdgeId edge) const {
    return numbers_[static_cast<std::size_t>(refinement - 1)].slot(edge).shape;
  }
  /// The levels of the faces of an edge that fill its grid.
  FaceLevels grid_levels() const noexcept { return {0, refinements_, depths_}; }
  /// Of an edge whose faces have all levels of the visit.
  EdgeDepths grid_depths() const noexcept { return {refinements_, refinements_}; }
  EdgeDepths depths_of(EdgeId edge) const noexcept {
    if (depths_ == nullptr) return grid_depths();
    const Edge& of = mesh_.edges[edge];
    const FaceLevels levels = grid_levels();
    const int own = levels.last_of(of.own.face());
    return {own, of.is_border() ? own : levels.last_of(of.other.face())};
  }
  /// How often all faces around a base vertex are refined, at most as often as the visit goes. Its
  /// ring is there.
  int ring_depth(VertexId vertex) const noexcept {
    return ring_depths_.empty() ? refinements_ : ring_depths_[vertex];
  }

  Needs needs() const;
  /// Calls edge_kernel(view, edge, worker) for each edge, from several threads, and then
  /// base_kernel(). The accesses of the view are in the order of the attributes. `stretch_done` is
  /// that of SweepPass.
  void run(const std::function<void(const SweepView&, EdgeId, int)>& edge_kernel,
           const std::function<void()>& base_kernel,
           const std::function<void()>& stretch_done = {}) const;

 private:
  SweepPass pass() const;
  void find_ring_depths();
  /// Of all attributes whose rings the visit reads, for one thread.
  std::uint64_t grid_bytes() const;
  void choose_threads();
  /// The base vertices of the visit.
  std::uint64_t base_vertices() const;
  /// The vertices of the levels that belong to edges from the first one of the visit on.
  std::uint64_t vertices_before(std::uint64_t edge) const;

  Store* store_;
  const VisitOptions* options_;
  int threads_ = 1;
  std::uint64_t lent_bytes_ = 0;  ///< grids of all threads but the first one
  std::vector<VisitedAttribute> attributes_;
  Topology mesh_;
  const FaceDepths* depths_;  ///< nullptr: all faces have all levels
  int level_ = 0, refinements_ = 0, first_refinement_ = 0;
  bool reads_rings_ = false;
  std::vector<LevelGeometry> numbers_;  ///< [refinement - 1] as if records had one byte
  std::optional<std::vector<VertexId>> own_vertices_;  ///< in the store of one part
  std::vector<std::uint8_t> ring_depths_;  ///< [vertex] if the visit reads rings and depths differ
};

PLAIT_END_NAMESPACE
