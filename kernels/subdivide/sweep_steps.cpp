#include <fmt/format.h>

#include <utility>
#include <vector>

#include "butterfly/odd_slots.h"
#include "normals/normal_rows.h"
#include "plait/detail/gather_grid.h"
#include "plait/error.h"
#include "plait/extend/sweep.h"
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
  options.progress = [&](const Progress& now) {
    run.report(pass.name, vertices, now.done, now.total);
    return true;
  };
  sweep(run.store, pass, options);
  run.vertices_before += vertices;
}

/// Collects the ring vertices on the edge from its slot. Several threads may do this for different
/// edges.
template <class Record>
void set_ring(RingTable<Record>& rings, EdgeId edge, BaseRelativeLevel level,
              const SlotRecords<Record>& slot) {
  const std::int64_t last = slot_side(level.refinements) - 1;
  rings.set(edge, slot.at(level.refinements, last, 0), slot.at(level.refinements, 0, last));
}

}  // namespace

std::vector<LevelAccess> odd_accesses(AttributeId position, int base_level, int level,
                                      int ring_count) {
  return {{position, base_level + 1, level - 1, Access::kRead,
           ring_count == 2 ? Reach::kRing : Reach::kFaces},
          {position, level, level, Access::kOverwrite}};
}

std::vector<LevelAccess> even_accesses(AttributeId position, int base_level, int level) {
  return {{position, level, level, Access::kRead, Reach::kFaces},
          {position, base_level + 1, level - 1, Access::kUpdate}};
}

std::vector<LevelAccess> surface_accesses(AttributeId position, int base_level, int level,
                                          AttributeId normal, AttributeId limit) {
  std::vector<LevelAccess> accesses = {
      {position, base_level + 1, level, Access::kRead, Reach::kFaces}};
  for (const AttributeId made : {normal, limit})
    if (made != kNoId) accesses.push_back({made, base_level + 1, level, Access::kOverwrite});
  return accesses;
}

template <class Real>
void SubdivisionRun<Real>::report(std::string_view phase, std::uint64_t vertices,
                                  std::uint64_t done, std::uint64_t count) const {
  if (!options.progress) return;
  const auto part = static_cast<std::uint64_t>(static_cast<double>(vertices) *
                                               (static_cast<double>(done) / double(count)));
  // The transparent executor is no pass of the engine, and allows more within its walk.
  const StorePass under_way(std::as_const(store));
  if (!options.progress({phase, vertices_before + part, vertices_total}))
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
  pass.accesses = odd_accesses(run.position, base_level, level, Rule::kRingCount);
  pass.kernel = [&](const SweepView& view, EdgeId edge, int worker) {
    EdgeGrid<Record>& grid = grids[static_cast<std::size_t>(worker)];
    const SlotSource<Record> source{view, 0, base_level};
    gather(mesh, source, base, edge, {0, coarser}, grid);
    const auto slot = view.slot(1, level, edge).template of<Record>();
    make_slot(source, edge, grid, slot);
    set_ring(run.rings, edge, relative, slot);
  };
  run_pass(run, pass, vertices_born(store, level, level));
}

template <class Real>
void move_even(SubdivisionRun<Real>& run, const OneRing<Real>& rule, int level) {
  using Record = Vector3<Real>;
  Store& store = run.store;
  const Topology mesh = store.base().topology();
  const int base_level = store.base_level();
  const std::span<const Record> base =
      std::as_const(store).template base_records<Record>(run.position);
  const int refinements = relative_to_base(level, base_level).refinements;
  std::vector<EdgeGrid<Record>> grids = make_grids(run, refinements);

  SweepPass pass;
  pass.name = fmt::format("level {}: even vertices", level);
  pass.accesses = even_accesses(run.position, base_level, level);
  pass.kernel = [&](const SweepView& view, EdgeId edge, int worker) {
    EdgeGrid<Record>& grid = grids[static_cast<std::size_t>(worker)];
    gather(mesh, SlotSource<Record>{view, 0, base_level}, base, edge, {refinements, refinements},
           grid);
    const bool border = mesh.edges[edge].is_border();
    for (int born = base_level + 1; born < level; ++born) {
      const auto slot = view.slot(1, born, edge).template of<Record>();
      rule.even_slot(grid, relative_to_base(born, base_level).refinements, {slot.shape, border},
                     slot.data());
    }
  };
  run_pass(run, pass, vertices_born(store, base_level + 1, level - 1));
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
  pass.accesses = surface_accesses(run.position, base_level, level, normal, limit);
  const std::size_t normal_access = 1, limit_access = pass.accesses.size() - 1;
  pass.kernel = [&](const SweepView& view, EdgeId edge, int worker) {
    EdgeGrid<Record>& grid = grids[static_cast<std::size_t>(worker)];
    gather(mesh, SlotSource<Record>{view, 0, base_level}, base, edge, {0, refinements}, grid);
    const bool border = mesh.edges[edge].is_border();
    for (int born = base_level + 1; born <= level; ++born) {
      const int times = relative_to_base(born, base_level).refinements;
      if (normal != kNoId) {
        const auto slot = view.slot(normal_access, born, edge).template of<Vector3<float>>();
        normals::slot_rows(grid, times, {slot.shape, border}, slot.data());
      }
      if constexpr (Rule::kRingCount == 1)
        if (limit != kNoId) {
          const auto slot = view.slot(limit_access, born, edge).template of<Record>();
          rule.limit_slot(grid, times, {slot.shape, border}, slot.data());
        }
    }
  };
  run_pass(run, pass, vertices_born(store, base_level + 1, level));
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
    set_ring(run.rings, edge, relative, view.slot(0, level, edge).template of<Record>());
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
