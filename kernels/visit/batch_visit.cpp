#include "visit/batch_visit.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <map>
#include <span>
#include <utility>

#include "address/record_sizes.h"
#include "plait/detail/edge_grid.h"
#include "plait/detail/ring_runs.h"
#include "plait/detail/ring_table.h"
#include "plait/extend/base_relative_level.h"
#include "plait/extend/store_access.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// The vertices of a batch, and its records of neighbours, after which it is handed over.
constexpr std::size_t kMostVertices = std::size_t{1} << 16;
constexpr std::size_t kMostNeighbours = 6 * kMostVertices;

/// Copies one record. The usual sizes are known while compiling.
void copy_record(std::byte* to, const std::byte* from, std::size_t bytes) noexcept {
  const bool copied =
      with_record_size(bytes, [&](const auto& record) { std::memcpy(to, from, sizeof(record)); });
  if (!copied) std::memcpy(to, from, bytes);
}

/// An attribute of the visit, and what the present edge has of it.
struct Source {
  Access access = Access::kRead;
  bool rings = false;
  std::size_t bytes = 0;            ///< of a record
  std::byte* base = nullptr;        ///< the records of the base vertices
  std::vector<std::byte> grid;      ///< the faces of an edge, as EdgeGrid has them
  std::vector<std::byte> spokes{};  ///< two records for each edge, as RingTable has them
};

/// The vertices with one number of neighbours that wait for their call.
class Batch {
 public:
  Batch(int valence, bool border, bool base, const std::vector<Source>& sources)
      : valence_(valence), border_(border), base_(base), sources_(&sources), of_(sources.size()) {}

  bool is_full() const {
    return levels_.size() >= kMostVertices ||
           levels_.size() * static_cast<std::size_t>(valence_) >= kMostNeighbours;
  }
  void add(int level, std::uint64_t place) {
    levels_.push_back(level);
    places_.push_back(place);
  }
  /// Adds the record of attribute `number` at `at`. What the call writes is copied to `at` again.
  void add_record(std::size_t number, std::byte* at) {
    const Source& source = (*sources_)[number];
    std::byte* const to = grown(of_[number].records, source.bytes);
    if (source.access != Access::kOverwrite) copy_record(to, at, source.bytes);
    if (source.access != Access::kRead) of_[number].written.push_back(at);
  }
  void add_neighbour(std::size_t number, const std::byte* at) {
    const std::size_t bytes = (*sources_)[number].bytes;
    copy_record(grown(of_[number].neighbours, bytes), at, bytes);
  }

  void hand_over(const std::function<void(const VertexBatch&)>& visit) {
    if (levels_.empty()) return;
    std::vector<BatchRecords> records;
    for (OfAttribute& each : of_)
      records.push_back(
          {each.records.data(), each.neighbours.empty() ? nullptr : each.neighbours.data()});
    visit(
        {levels_.size(), valence_, border_, base_, levels_.data(), places_.data(), records.data()});
    for (std::size_t number = 0; number < of_.size(); ++number) {
      const std::size_t bytes = (*sources_)[number].bytes;
      const std::byte* from = of_[number].records.data();
      for (std::byte* const to : of_[number].written) {
        copy_record(to, from, bytes);
        from += bytes;
      }
    }
    clear();
  }

 private:
  struct OfAttribute {
    std::vector<std::byte> records, neighbours;
    std::vector<std::byte*> written;  ///< where each record goes
  };

  static std::byte* grown(std::vector<std::byte>& bytes, std::size_t by) {
    bytes.resize(bytes.size() + by);
    return bytes.data() + bytes.size() - by;
  }
  void clear() {
    levels_.clear();
    places_.clear();
    for (OfAttribute& each : of_) {
      each.records.clear();
      each.neighbours.clear();
      each.written.clear();
    }
  }

  int valence_;
  bool border_, base_;
  const std::vector<Source>* sources_;
  std::vector<std::int32_t> levels_;
  std::vector<std::uint64_t> places_;
  std::vector<OfAttribute> of_;
};

/// One visit.
class BatchVisit {
 public:
  BatchVisit(const VisitPlan& plan, const std::vector<BatchAttribute>& attributes,
             const std::function<void(const VertexBatch&)>& visit)
      : plan_(plan),
        visit_(visit),
        mesh_(plan.store().base().topology()),
        depths_(plan.grid_depths()),
        grid_(plan.refinements()),
        sources_(sources_of(plan, attributes)) {
    for (Source& source : sources_) {
      if (!source.rings) continue;
      source.spokes.resize(2 * source.bytes * mesh_.edges.size());
      if (plan.refinements() > 0) {
        source.grid.resize(source.bytes * grid_.point_count());
        continue;
      }
      for (std::size_t edge = 0; edge < mesh_.edges.size(); ++edge)
        set_spokes(source, edge, source.base + mesh_.edges[edge].end * source.bytes,
                   source.base + mesh_.edges[edge].start * source.bytes);
    }
  }

  void run() {
    plan_.run([&](const SweepView& view, EdgeId edge, int) { add_edge(view, edge); },
              [&] {
                if (plan_.visits_base()) visit_base();
              },
              [&] { hand_over_all(); });
  }

 private:
  static std::vector<Source> sources_of(const VisitPlan& plan,
                                        const std::vector<BatchAttribute>& attributes) {
    std::vector<Source> sources;
    for (std::size_t number = 0; number < attributes.size(); ++number) {
      const BatchAttribute& of = attributes[number];
      const AttributeId id = plan.attribute(number);
      sources.push_back({of.access,
                         of.rings,
                         plan.store().attributes()[id].schema.record_bytes(),
                         plan.base_bytes(number).data(),
                         {},
                         {}});
    }
    return sources;
  }

  void set_spokes(Source& source, std::size_t edge, const std::byte* next_to_start,
                  const std::byte* next_to_end) {
    std::byte* const to = source.spokes.data() + 2 * edge * source.bytes;
    copy_record(to, next_to_start, source.bytes);
    copy_record(to + source.bytes, next_to_end, source.bytes);
  }

  std::byte* in_grid(Source& source, std::int64_t p, std::int64_t q) const {
    return source.grid.data() + static_cast<std::size_t>(grid_.place(p, q)) * source.bytes;
  }

  void gather(const SweepView& view, std::size_t number, EdgeId edge) {
    Source& source = sources_[number];
    std::byte* const origin = in_grid(source, 0, 0);
    const auto at = [&](std::int64_t point) {
      return origin + point * static_cast<std::ptrdiff_t>(source.bytes);
    };
    for_each_place_around(
        mesh_, edge, grid_,
        [&](int level, EdgeId of) { return view.slot(number, level_of(level), of); },
        plan_.grid_levels(),
        [&](std::int64_t point, VertexId vertex) {
          copy_record(at(point), source.base + vertex * source.bytes, source.bytes);
        },
        [&](std::int64_t point, const LocatedSlot& slot, std::int64_t position) {
          copy_record(at(point),
                      slot.bytes.data() + static_cast<std::size_t>(position) * source.bytes,
                      source.bytes);
        });
    const auto to_next = [&](VertexId vertex) {
      return std::int64_t{1} << (grid_.level - plan_.ring_depth(vertex));
    };
    const std::int64_t from_start = to_next(mesh_.edges[edge].start);
    const std::int64_t from_end = to_next(mesh_.edges[edge].end);
    set_spokes(source, edge, in_grid(source, grid_.size - from_start, from_start),
               in_grid(source, from_end, grid_.size - from_end));
  }

  int level_of(int refinement) const {
    return level_number(BaseRelativeLevel(refinement), plan_.store().base_level());
  }

  void add_edge(const SweepView& view, EdgeId edge) {
    if (plan_.reads_rings()) set_depths(plan_.depths_of(edge));
    for (std::size_t number = 0; number < sources_.size(); ++number)
      if (sources_[number].rings) gather(view, number, edge);
    for (int refinement = plan_.first_refinement(); refinement <= plan_.refinements();
         ++refinement) {
      const VertexRun slot = plan_.run_of(refinement, edge, 0);
      if (!plan_.reads_rings()) {
        for (std::size_t position = 0; position < slot.count; ++position)
          add_record(view, slot, position);
        continue;
      }
      for_each_ring_run(depths_, plan_.shape_of(refinement, edge), refinement,
                        [&](const RingRun& run, auto) { add_run(view, slot, run); });
    }
  }

  /// The grids are large enough for the finest level of the visit.
  void set_depths(const EdgeDepths& depths) {
    if (depths == depths_) return;
    depths_ = depths;
    grid_ = GridShape(depths.deeper());
  }

  /// A vertex of a visit without rings.
  void add_record(const SweepView& view, const VertexRun& slot, std::size_t position) {
    Batch& batch = batch_of(0, false, false);
    batch.add(slot.level, slot.first + position);
    for (std::size_t number = 0; number < sources_.size(); ++number)
      batch.add_record(number, view.slot(number, slot.level, slot.edge).bytes.data() +
                                   position * sources_[number].bytes);
    if (batch.is_full()) batch.hand_over(visit_);
  }

  void add_run(const SweepView& view, const VertexRun& slot, const RingRun& run) {
    const RingSteps all(grid_.stride, std::ptrdiff_t{1} << (grid_.level - run.depth));
    const std::span<const std::ptrdiff_t> steps = all.of(run.extent);
    for (std::size_t i = 0; i < run.count; ++i) {
      Batch& batch =
          batch_of(static_cast<int>(steps.size()), run.extent != RingExtent::kWhole, false);
      const std::size_t position = run.position + i;
      batch.add(slot.level, slot.first + position);
      for (std::size_t number = 0; number < sources_.size(); ++number) {
        Source& source = sources_[number];
        if (!source.rings) {
          batch.add_record(number, view.slot(number, slot.level, slot.edge).bytes.data() +
                                       position * source.bytes);
          continue;
        }
        const auto bytes = static_cast<std::ptrdiff_t>(source.bytes);
        std::byte* const at =
            in_grid(source, run.p, run.q + static_cast<std::int64_t>(i) * run.step);
        batch.add_record(number, at);
        for (const std::ptrdiff_t step : steps) batch.add_neighbour(number, at + step * bytes);
      }
      if (batch.is_full()) batch.hand_over(visit_);
    }
  }

  void visit_base() {
    const bool rings = plan_.reads_rings();
    if (plan_.refinements() > 0)
      for (std::size_t number = 0; number < sources_.size(); ++number)
        if (sources_[number].rings)
          plan_.for_each_outer_spoke(
              number, [&](EdgeId edge, const std::byte* to_start, const std::byte* to_end) {
                set_spokes(sources_[number], edge, to_start, to_end);
              });
    std::vector<std::pair<EdgeId, bool>> spokes;  // the edge, and whether the vertex is its end
    const auto visit = [&](VertexId vertex) {
      spokes.clear();
      if (rings)
        for_each_spoke(mesh_, vertex, [&](EdgeId edge) {
          spokes.emplace_back(edge, mesh_.edges[edge].end == vertex);
        });
      Batch& batch =
          batch_of(static_cast<int>(spokes.size()), rings && is_border_vertex(mesh_, vertex), true);
      batch.add(plan_.store().base_level(), vertex);
      for (std::size_t number = 0; number < sources_.size(); ++number) {
        const Source& source = sources_[number];
        batch.add_record(number, source.base + vertex * source.bytes);
        if (!source.rings) continue;
        for (const auto& [edge, at_end] : spokes)
          batch.add_neighbour(
              number, source.spokes.data() + (2 * std::size_t{edge} + at_end) * source.bytes);
      }
      if (batch.is_full()) batch.hand_over(visit_);
    };
    plan_.for_each_base_run([&](const VertexRun& run) {
      for (std::size_t i = 0; i < run.count; ++i) visit(static_cast<VertexId>(run.first + i));
    });
    hand_over_all();
  }

  Batch& batch_of(int valence, bool border, bool base) {
    const std::array<int, 3> key{valence, border, base};
    if (key == last_key_ && last_ != nullptr) return *last_;
    const auto [found, is_new] = batches_.try_emplace(key, valence, border, base, sources_);
    last_key_ = key;
    last_ = &found->second;
    return *last_;
  }
  void hand_over_all() {
    for (auto& [key, batch] : batches_) batch.hand_over(visit_);
  }

  const VisitPlan& plan_;
  const std::function<void(const VertexBatch&)>& visit_;
  Topology mesh_;
  EdgeDepths depths_;  ///< of the present edge
  GridShape grid_;
  std::vector<Source> sources_;
  std::map<std::array<int, 3>, Batch> batches_;  ///< [valence, border, base]
  std::array<int, 3> last_key_{};
  Batch* last_ = nullptr;
};

std::vector<VisitedAttribute> visited(const Store& store,
                                      const std::vector<BatchAttribute>& attributes) {
  std::vector<VisitedAttribute> visited;
  for (const BatchAttribute& each : attributes) {
    const AttributeSchema& schema = store.attributes()[store.attribute(each.name)].schema;
    visited.push_back({each.name, schema.type, schema.components, each.access, each.rings});
  }
  return visited;
}

}  // namespace

void visit_batches(Store& store, const VisitOptions& options, int first_level,
                   const std::vector<BatchAttribute>& attributes,
                   const std::function<void(const VertexBatch&)>& visit) {
  if (options.threads != 1)
    throw Error(ErrorCode::kInvalidArgument, "visit batches: expected 1 thread");
  const VisitPlan plan(store, options, visited(store, attributes), first_level);
  BatchVisit(plan, attributes, visit).run();
}

PLAIT_END_NAMESPACE
