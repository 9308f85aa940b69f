// plait/visit_vertices.h: visits every vertex of a store once, base vertices too, and gives
// a kernel of the program the records of these vertices and, if wanted, their neighbours.
//
//   visit_vertices(store, {.name = "smooth"},
//                  std::tuple{rings_of<Point>("position"), overwrites<Point>("smooth")},
//                  [](const VertexRun& run, const VertexRings<Point>& position,
//                     std::span<Point> smooth) {
//                    for (std::size_t i = 0; i < run.count; ++i)
//                      smooth[i] = ... position.neighbour(i, k) ...;
//                  });
//
// The visit is one sweep (plait/extend/sweep.h): every block is read and written at most once,
// within the budget of the store. The sweep goes from edge to edge in layout order, with all levels
// at once, because the rings of all levels are at the finest level. Then follow the base vertices,
// because the sweep finds their rings on its way. One kernel call gets a row of a slot, or a whole
// slot if the visit reads no rings; of base vertices it gets one, or without rings all (in a part
// of a pass over machines, those of the part: plait/extend/pass.h).
//
// Source of the method: I. Guskov, "Non-replicating indexing for out-of-core processing of
// semi-regular triangular surface meshes". Pinned by tests/kernels/visit_vertices_test.cpp; shown
// in docs/writing.md.
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "plait/detail/edge_grid.h"
#include "plait/detail/gather_grid.h"
#include "plait/detail/namespace.h"
#include "plait/detail/ring_runs.h"
#include "plait/detail/ring_table.h"
#include "plait/detail/visit_plan.h"
#include "plait/extend/base_relative_level.h"
#include "plait/vertex_rings.h"
#include "plait/visit_options.h"

PLAIT_BEGIN_NAMESPACE

/// What a visit does with an attribute. Made by the four functions below.
template <class RecordType>
struct RingsOf {
  using Record = RecordType;
  using Argument = VertexRings<Record>;
  static constexpr Access kAccess = Access::kRead;
  static constexpr bool kRings = true;
  std::string_view attribute;
};
/// The same for a kernel that gets the records without their neighbours.
template <class RecordType, Access kHow>
struct RecordsOf {
  using Record = RecordType;
  using Argument = std::span<std::conditional_t<kHow == Access::kRead, const Record, Record>>;
  static constexpr Access kAccess = kHow;
  static constexpr bool kRings = false;
  std::string_view attribute;
};

/// The kernel reads each vertex and its neighbours: it gets a VertexRings<Record>.
template <class Record>
RingsOf<Record> rings_of(std::string_view attribute) {
  return {attribute};
}
/// The kernel reads each vertex: it gets a std::span<const Record> of VertexRun::count records.
template <class Record>
RecordsOf<Record, Access::kRead> reads(std::string_view attribute) {
  return {attribute};
}
/// The kernel writes each vertex and reads none: it gets a std::span<Record> of undefined content,
/// and must fill all of it. Nothing is read from the disk.
template <class Record>
RecordsOf<Record, Access::kOverwrite> overwrites(std::string_view attribute) {
  return {attribute};
}
/// The kernel changes each vertex in place: it gets a std::span<Record> with the present content.
template <class Record>
RecordsOf<Record, Access::kUpdate> updates(std::string_view attribute) {
  return {attribute};
}

// How one attribute comes to the kernel: begin() is called once for an edge, at() for each run of
// its vertices, begin_base() once before the base vertices, and base() for each run of them.
namespace visit {

/// Vertices of a row of a slot, or a whole slot.
struct VertexPlace {
  std::size_t access;
  EdgeId edge;
  int worker;
  VertexRun run;
  RingRun rings;  ///< of all vertices of the run; position 0 if the visit reads no rings
};

template <class Spec>
class Source;

template <class Record, Access kHow>
class Source<RecordsOf<Record, kHow>> {
 public:
  using Argument = typename RecordsOf<Record, kHow>::Argument;
  Source(const VisitPlan& plan, std::size_t access) {
    const std::span<std::byte> bytes = plan.base_bytes(access);
    base_ = {reinterpret_cast<Record*>(bytes.data()), bytes.size() / sizeof(Record)};
  }
  void begin(const SweepView&, std::size_t, EdgeId, int) noexcept {}
  void begin_base(const VisitPlan&, std::size_t) noexcept {}
  template <class HasWholeRings>
  Argument at(const SweepView& view, const VertexPlace& place, HasWholeRings) const noexcept {
    return view.records<typename Argument::element_type>(place.access, place.run.level, place.edge)
        .subspan(place.rings.position, place.run.count);
  }
  Argument base(const VertexRun& run) const noexcept {
    return base_.subspan(static_cast<std::size_t>(run.first), run.count);
  }

 private:
  Argument base_;
};

template <class Record>
class Source<RingsOf<Record>> {
 public:
  Source(const VisitPlan& plan, std::size_t access)
      : plan_(plan),
        mesh_(plan.store().base().topology()),
        base_level_(plan.store().base_level()),
        base_(std::as_const(plan.store()).template base_records<Record>(plan.attribute(access))),
        rings_(mesh_.edges.size()),
        around_edges_(plan.refinements() > 0 ? static_cast<std::size_t>(plan.threads()) : 0) {
    if (plan.refinements() == 0) rings_.set_from_base(mesh_, base_);
    for (AroundEdge& around : around_edges_) around.set(plan.grid_depths());
  }
  void begin(const SweepView& view, std::size_t access, EdgeId edge, int worker) {
    AroundEdge& around = around_edges_[static_cast<std::size_t>(worker)];
    if (const EdgeDepths depths = plan_.depths_of(edge); depths != around.depths)
      around.set(depths);
    EdgeGrid<Record>& grid = around.grid;
    gather(mesh_, SlotSource<Record>{view, access, base_level_}, base_, edge, plan_.grid_levels(),
           grid);
    const auto to_next = [&](VertexId vertex) {
      return std::int64_t{1} << (grid.level() - plan_.ring_depth(vertex));
    };
    const std::int64_t from_start = to_next(mesh_.edges[edge].start);
    const std::int64_t from_end = to_next(mesh_.edges[edge].end);
    rings_.set(edge, *grid.at(grid.size() - from_start, from_start),
               *grid.at(from_end, grid.size() - from_end));
  }
  template <bool kHasWholeRings>
  VertexRings<Record> at(const SweepView&, const VertexPlace& place,
                         std::bool_constant<kHasWholeRings>) const noexcept {
    const AroundEdge& around = around_edges_[static_cast<std::size_t>(place.worker)];
    const RingRun& run = place.rings;
    const RingSteps& steps = run.depth == around.depths.own ? around.own : around.other;
    const Record* const first = around.grid.at(run.p, run.q);
    if constexpr (kHasWholeRings)
      return {first, run.step, steps.whole.data(), 6, false};
    else
      return {first, run.step, steps.of(run.extent).data(), 4, true};
  }
  void begin_base(const VisitPlan& plan, std::size_t access) {
    if (plan.refinements() == 0) return;
    plan.for_each_outer_spoke(
        access, [&](EdgeId edge, const std::byte* next_to_start, const std::byte* next_to_end) {
          rings_.set(edge, *reinterpret_cast<const Record*>(next_to_start),
                     *reinterpret_cast<const Record*>(next_to_end));
        });
  }
  /// One base vertex. The result is valid until the next call.
  VertexRings<Record> base(const VertexRun& run) {
    const auto vertex = static_cast<VertexId>(run.first);
    around_.assign(1, base_[vertex]);
    const int valence = for_each_spoke(mesh_, vertex, [&](EdgeId edge) {
      around_.push_back(rings_.next_to(mesh_, edge, vertex));
    });
    while (in_order_.size() < around_.size())
      in_order_.push_back(static_cast<std::ptrdiff_t>(in_order_.size()) + 1);
    return {around_.data(), 0, in_order_.data(), valence, is_border_vertex(mesh_, vertex)};
  }

 private:
  /// The grid of an edge, and the rings in it at the depths of both faces.
  struct AroundEdge {
    EdgeGrid<Record> grid;
    EdgeDepths depths;
    RingSteps own, other;

    void set(const EdgeDepths& now) {
      depths = now;
      grid.resize(now.deeper());
      own = RingSteps(grid.stride(), std::ptrdiff_t{1} << (now.deeper() - now.own));
      other = RingSteps(grid.stride(), std::ptrdiff_t{1} << (now.deeper() - now.other));
    }
  };

  const VisitPlan& plan_;
  Topology mesh_;
  int base_level_;
  std::span<const Record> base_;
  RingTable<Record> rings_;
  std::vector<AroundEdge> around_edges_;  ///< [worker]
  std::vector<Record> around_;            ///< a base vertex and its neighbours
  std::vector<std::ptrdiff_t> in_order_;
};

template <class... Specs>
std::vector<VisitedAttribute> attributes_of(const std::tuple<Specs...>& attributes) {
  return std::apply(
      [](const Specs&... each) {
        return std::vector<VisitedAttribute>{
            {each.attribute, RecordTraits<typename Specs::Record>::kType,
             RecordTraits<typename Specs::Record>::kComponents, Specs::kAccess, Specs::kRings}...};
      },
      attributes);
}

template <class Kernel, class... Specs>
inline constexpr bool kIsKernel =
    std::invocable<const Kernel&, const VertexRun&, typename Specs::Argument...>;

template <class Kernel, class... Specs, std::size_t... kNumbers>
void run(const VisitPlan& plan, const Kernel& kernel, std::tuple<Source<Specs>...>& sources,
         std::index_sequence<kNumbers...>) {
  plan.run(
      [&](const SweepView& view, EdgeId edge, int worker) {
        (std::get<kNumbers>(sources).begin(view, kNumbers, edge, worker), ...);
        const auto call = [&](VertexPlace& place, auto has_whole_rings) {
          const auto at = [&](auto& source, std::size_t access) {
            place.access = access;
            return source.at(view, place, has_whole_rings);
          };
          kernel(std::as_const(place.run), at(std::get<kNumbers>(sources), kNumbers)...);
        };
        for (int refinement = 1; refinement <= plan.refinements(); ++refinement) {
          VertexPlace place{0, edge, worker, plan.run_of(refinement, edge, worker), {}};
          if constexpr ((Specs::kRings || ...))
            for_each_ring_run(plan.depths_of(edge), plan.shape_of(refinement, edge), refinement,
                              [&, first = place.run.first](const RingRun& rings, auto is_whole) {
                                place.run.first = first + rings.position;
                                place.run.count = rings.count;
                                place.rings = rings;
                                call(place, is_whole);
                              });
          else if (place.run.count > 0)
            call(place, std::true_type{});
        }
      },
      [&] {
        (std::get<kNumbers>(sources).begin_base(plan, kNumbers), ...);
        plan.for_each_base_run([&](const VertexRun& base) {
          kernel(base, std::get<kNumbers>(sources).base(base)...);
        });
      });
}

}  // namespace visit

/// Calls kernel(const VertexRun&, argument for each attribute...) until every vertex of levels 0 to
/// options.level was in exactly one call. `attributes` is a std::tuple of results of rings_of(),
/// reads(), overwrites() and updates(). No attribute may be in it twice: a pass that reads rings of
/// an attribute writes to another one, because otherwise the result would depend on the order.
/// Store::replace_attribute() then gives the new one the name of the old one.
///
/// In a store whose faces have depths of their own (docs/adaptive.md), a visit has the vertices
/// that there are, and their rings are those that VertexRings describes. Where both faces of an
/// edge have different depths, a row of a slot comes in up to three calls.
///
/// The kernel is called from several threads at once (docs/threads.md) if options.threads > 1, for
/// base vertices from the calling thread alone. It must not call functions of `store`. If it
/// throws, the visit ends with one of the exceptions. Each result depends only on what the kernel
/// reads, so the bits do not depend on threads, blocks and budget.
///
/// Errors, before anything is changed: those of VisitPlan; kBudget (the message says how much is
/// needed). Later: kCancelled; those of Session::pin. After an error, the levels that the visit
/// writes cannot be committed until a pass has overwritten them.
template <class... Specs, class Kernel>
void visit_vertices(Store& store, const VisitOptions& options,
                    const std::tuple<Specs...>& attributes, const Kernel& kernel) {
  static_assert(visit::kIsKernel<Kernel, Specs...>,
                "visit_vertices: the kernel must be callable, from several threads at once (so its "
                "operator() is const), as kernel(const VertexRun&, argument of each attribute...): "
                "VertexRings<Record> for rings_of, std::span<const Record> for reads, "
                "std::span<Record> for overwrites and updates");
  if constexpr (visit::kIsKernel<Kernel, Specs...>) {
    const VisitPlan plan(store, options, visit::attributes_of(attributes));
    const auto numbers = std::index_sequence_for<Specs...>();
    [&]<std::size_t... kNumbers>(std::index_sequence<kNumbers...>) {
      std::tuple<visit::Source<Specs>...> sources(visit::Source<Specs>(plan, kNumbers)...);
      visit::run<Kernel, Specs...>(plan, kernel, sources, numbers);
    }
    (numbers);
  }
}

/// The memory that visit_vertices() needs with the same arguments; resident: for each attribute
/// whose rings it reads, the grid of an edge, and two records for each base edge. The budget lends
/// the grids of further threads.
/// Errors: those of VisitPlan.
template <class... Specs>
Needs visit_needs(Store& store, const VisitOptions& options,
                  const std::tuple<Specs...>& attributes) {
  return VisitPlan(store, options, visit::attributes_of(attributes)).needs();
}

PLAIT_END_NAMESPACE
