#include <fmt/format.h>

#include <utility>
#include <vector>

#include "butterfly/odd_slots.h"
#include "normals/normal_rows.h"
#include "normals/normal_rules.h"
#include "plait/error.h"
#include "plait/kernels/base_vertices.h"
#include "plait/kernels/gather_grid.h"
#include "plait/sweep.h"
#include "schemes/one_ring_steps.h"
#include "subdivide/steps.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

template <class Real>
std::vector<EdgeGrid<Vector3<Real>>> make_grids(const SubdivisionRun<Real>& run, int refinements) {
  std::vector<EdgeGrid<Vector3<Real>>> result(static_cast<std::size_t>(run.options.threads));
  for (auto& grid : result) grid.resize(refinements);
  return result;
}

template <class Real>
void run_pass(SubdivisionRun<Real>& run, const SweepPass& pass, std::uint64_t vertices) {
  SweepOptions options;
  options.threads = run.options.threads;
  options.proceed = [&](std::uint64_t done, std::uint64_t count) {
    run.report(pass.name, vertices, done, count);
    return true;
  };
  sweep(run.store, pass, options);
  run.vertices_before += vertices;
}

std::uint64_t vertices_born(const Store& store, int first, int last) {
  std::uint64_t vertices = 0;
  for (int level = first; level <= last; ++level) {
    const int refinements = relative_to_base(level, store.base_level()).refinements;
    vertices +=
        (store.base().edge_count() - store.base().border_edge_count()) * slot_records(refinements) +
        store.base().border_edge_count() * slot_records(refinements, true);
  }
  return vertices;
}

/// Collects the ring vertices on the edge from its slot. Several threads may do this for different
/// edges.
template <class Record>
void set_ring(RingTable<Record>& rings, const Topology& mesh, EdgeId edge, BaseRelativeLevel level,
              std::span<const Record> slot) {
  const std::int64_t last = slot_side(level.refinements) - 1;
  const bool border = mesh.edges[edge].is_border();
  const auto at = [&](std::int64_t row, std::int64_t column) {
    return slot[static_cast<std::size_t>(slot_position(level.refinements, border, row, column))];
  };
  rings.set(edge, at(last, 0), at(0, last));
}

}  // namespace

template <class Real>
void SubdivisionRun<Real>::report(std::string_view phase, std::uint64_t vertices,
                                  std::uint64_t done, std::uint64_t count) const {
  if (!options.proceed) return;
  const auto part = static_cast<std::uint64_t>(static_cast<double>(vertices) *
                                               (static_cast<double>(done) / double(count)));
  if (!options.proceed({phase, vertices_before + part, vertices_total}))
    throw Error(ErrorCode::kCancelled, fmt::format("subdivide, {}: cancelled", phase));
}

template <class Rule>
void make_odd(SubdivisionRun<typename Rule::Real>& run, const Rule& rule, int level) {
  using Record = Vector3<typename Rule::Real>;
  Store& store = run.store;
  const Topology mesh = store.base().topology();
  const int base_level = store.base_level();
  const std::span<const Record> base =
      std::as_const(store).template base_records<Record>(run.position);
  const BaseRelativeLevel relative = relative_to_base(level, base_level);
  const int coarser = relative.refinements - 1;
  std::vector<EdgeGrid<Record>> grids = make_grids(run, coarser);
  const auto make_slot = odd_slots(rule, mesh, run.rings, base);

  SweepPass pass;
  pass.name = fmt::format("level {}: odd vertices", level);
  pass.accesses = {{run.position, base_level + 1, level - 1, Access::kRead,
                    Rule::kReach == 2 ? Reach::kRing : Reach::kFaces},
                   {run.position, level, level, Access::kOverwrite}};
  pass.kernel = [&](const SweepView& view, EdgeId edge, int worker) {
    EdgeGrid<Record>& grid = grids[static_cast<std::size_t>(worker)];
    const SlotSource<Record> source{view, 0, base_level};
    gather(mesh, source, base, edge, 0, coarser, grid);
    const std::span<Record> slot = view.records<Record>(1, level, edge);
    make_slot(source, edge, grid, slot.data());
    set_ring(run.rings, mesh, edge, relative, std::span<const Record>(slot));
  };
  run_pass(run, pass, vertices_born(store, level, level));
}

template <class Real>
void move_even(SubdivisionRun<Real>& run, const OneRing<Real>& rule, int level) {
  using Record = Vector3<Real>;
  Store& store = run.store;
  const Topology mesh = store.base().topology();
  const int base_level = store.base_level();
  const std::span<Record> base = store.base_records<Record>(run.position);
  const int refinements = relative_to_base(level, base_level).refinements;
  if (refinements > 1) {
    std::vector<EdgeGrid<Record>> grids = make_grids(run, refinements);
    SweepPass pass;
    pass.name = fmt::format("level {}: even vertices", level);
    pass.accesses = {{run.position, level, level, Access::kRead, Reach::kFaces},
                     {run.position, base_level + 1, level - 1, Access::kUpdate}};
    pass.kernel = [&](const SweepView& view, EdgeId edge, int worker) {
      EdgeGrid<Record>& grid = grids[static_cast<std::size_t>(worker)];
      gather(mesh, SlotSource<Record>{view, 0, base_level}, std::span<const Record>(base), edge,
             refinements, refinements, grid);
      for (int born = base_level + 1; born < level; ++born)
        rule.even_slot(grid, relative_to_base(born, base_level).refinements,
                       mesh.edges[edge].is_border(), view.records<Record>(1, born, edge).data());
    };
    run_pass(run, pass, vertices_born(store, base_level + 1, level - 1));
  }
  move_base_vertices(mesh, run.rings, rule, base);
}

template <class Rule>
void make_surface(SubdivisionRun<typename Rule::Real>& run, const Rule& rule, int level,
                  AttributeId normal, AttributeId limit) {
  using Record = Vector3<typename Rule::Real>;
  Store& store = run.store;
  const Topology mesh = store.base().topology();
  const int base_level = store.base_level();
  const std::span<const Record> base =
      std::as_const(store).template base_records<Record>(run.position);
  const int refinements = relative_to_base(level, base_level).refinements;
  std::vector<EdgeGrid<Record>> grids = make_grids(run, refinements);

  SweepPass pass;
  pass.name = normal == kNoId  ? "limit positions"
              : limit == kNoId ? "normals"
                               : "normals and limit positions";
  pass.accesses = {{run.position, base_level + 1, level, Access::kRead, Reach::kFaces}};
  const std::size_t normal_access = pass.accesses.size();
  if (normal != kNoId) pass.accesses.push_back({normal, base_level + 1, level, Access::kOverwrite});
  const std::size_t limit_access = pass.accesses.size();
  if (limit != kNoId) pass.accesses.push_back({limit, base_level + 1, level, Access::kOverwrite});
  pass.kernel = [&](const SweepView& view, EdgeId edge, int worker) {
    EdgeGrid<Record>& grid = grids[static_cast<std::size_t>(worker)];
    gather(mesh, SlotSource<Record>{view, 0, base_level}, base, edge, 0, refinements, grid);
    const bool border = mesh.edges[edge].is_border();
    for (int born = base_level + 1; born <= level; ++born) {
      const int times = relative_to_base(born, base_level).refinements;
      if (normal != kNoId)
        normals::slot_rows(grid, times, border,
                           view.records<Vector3<float>>(normal_access, born, edge).data());
      if constexpr (Rule::kReach == 1)
        if (limit != kNoId)
          rule.limit_slot(grid, times, border,
                          view.records<Record>(limit_access, born, edge).data());
    }
  };
  if (refinements > 0) run_pass(run, pass, vertices_born(store, base_level + 1, level));
  if (normal != kNoId)
    normals::base(mesh, run.rings, base, store.base_records<Vector3<float>>(normal));
  if constexpr (Rule::kReach == 1)
    if (limit != kNoId)
      limit_base_vertices(mesh, run.rings, rule, base, store.base_records<Record>(limit));
}

template <class Real>
void read_rings(SubdivisionRun<Real>& run, int level) {
  using Record = Vector3<Real>;
  const Topology mesh = run.store.base().topology();
  const BaseRelativeLevel relative = relative_to_base(level, run.store.base_level());
  if (relative == BaseRelativeLevel(0)) {
    run.rings.set_from_base(mesh,
                            std::as_const(run.store).template base_records<Record>(run.position));
    return;
  }
  SweepPass pass;
  pass.name = fmt::format("level {}: rings of the base vertices", level);
  pass.accesses = {{run.position, level, level, Access::kRead, Reach::kOwn}};
  pass.kernel = [&](const SweepView& view, EdgeId edge, int) {
    set_ring(run.rings, mesh, edge, relative, view.records<const Record>(0, level, edge));
  };
  run_pass(run, pass, 0);
}

template struct SubdivisionRun<float>;
template struct SubdivisionRun<double>;
template void make_odd(SubdivisionRun<float>&, const OneRing<float>&, int);
template void make_odd(SubdivisionRun<double>&, const OneRing<double>&, int);
template void make_odd(SubdivisionRun<float>&, const Butterfly<float>&, int);
template void make_odd(SubdivisionRun<double>&, const Butterfly<double>&, int);
template void move_even(SubdivisionRun<float>&, const OneRing<float>&, int);
template void move_even(SubdivisionRun<double>&, const OneRing<double>&, int);
template void make_surface(SubdivisionRun<float>&, const OneRing<float>&, int, AttributeId,
                           AttributeId);
template void make_surface(SubdivisionRun<double>&, const OneRing<double>&, int, AttributeId,
                           AttributeId);
template void make_surface(SubdivisionRun<float>&, const Butterfly<float>&, int, AttributeId,
                           AttributeId);
template void make_surface(SubdivisionRun<double>&, const Butterfly<double>&, int, AttributeId,
                           AttributeId);
template void read_rings(SubdivisionRun<float>&, int);
template void read_rings(SubdivisionRun<double>&, int);

PLAIT_END_NAMESPACE
