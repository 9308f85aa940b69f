#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "base/zeroed_array.h"
#include "butterfly/base_middles.h"
#include "fused/surface_refiner.h"
#include "mesh/mesh_region.h"
#include "plait/extend/base_relative_level.h"
#include "plait/extend/fused.h"
#include "plait/extend/store_access.h"
#include "schemes/one_ring_steps.h"
#include "subdivide/steps.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

BaseRelativeLevel finest(const Store& store, const SubdivideOptions& options) {
  return relative_to_base(options.levels, store.base_level());
}

FusedPass fused_pass(const Store& store, const SubdivideOptions& options, int ring_count,
                     AttributeId position, AttributeId normal) {
  FusedPass pass;
  pass.name = "subdivision";
  pass.outputs = {position};
  if (normal != kNoId) pass.outputs.push_back(normal);
  pass.finest_level = options.levels;
  pass.lattice = surface_lattice(finest(store, options).refinements, ring_count);
  return pass;
}

}  // namespace

template <class Rule>
void run_fused(SubdivisionRun<typename Rule::Real>& run, const Rule& rule, AttributeId normal) {
  using Real = typename Rule::Real;
  Store& store = run.store;
  const SubdivideOptions& options = run.options;
  const int levels = finest(store, options).refinements;
  const std::span<Vector3<Real>> base =
      StoreAccess::base_records<Vector3<Real>>(store, run.position);
  // The patches read the base mesh until the last one is done, so the results are separate arrays.
  ZeroedArray<Vector3<Real>> positions(base.size()), limits(options.limit ? base.size() : 0);

  const Topology mesh = store.base().topology();
  const std::vector<Vector3<Real>> middles =
      first_middles(rule, mesh, std::span<const Vector3<Real>>(base));
  SurfaceRefinement<Rule> refinement{{rule, mesh, base, levels, middles}, {positions, limits, {}}};
  if (normal != kNoId)
    refinement.results.normals = StoreAccess::base_records<Vector3<float>>(store, normal);

  BaseRings<Rule> hubs(refinement.source);
  hubs.evaluate_hubs(BaseRings<Rule>::find_hubs(store.base()));
  refinement.source.hubs = &hubs;

  FusedPass pass = fused_pass(store, options, Rule::kRingCount, run.position, normal);
  pass.make_refiner = [&] { return make_refiner(refinement); };
  FusedOptions how;
  how.threads = options.threads;
  how.progress = [&](const Progress& now) {
    run.report("subdivision", run.vertices_total, now.done, now.total);
    return true;
  };
  fused(store, pass, how);
  const std::span<const Vector3<Real>> results = options.limit ? limits : positions;
  const VerticesAtHand vertices = walkable_vertices(store.base());
  for (std::size_t at = 0; at < vertices.size(); ++at) base[vertices[at]] = results[vertices[at]];
}

template <class Rule>
std::uint64_t fused_resident_bytes(const Store& store, const SubdivideOptions& options) {
  using Real = typename Rule::Real;
  const EdgeRange here = StoreAccess::edges(store);
  const std::uint64_t vertices = walkable_vertices(store.base()).size(),
                      edges = store.base().edge_count();
  const int levels = finest(store, options).refinements;
  const std::array<std::size_t, 2> records = {sizeof(Vector3<Real>), sizeof(Vector3<float>)};
  // A scheme of two rings has level 1 in memory. The rings and the values in double from
  // which level 1 is made are freed before the pass allocates its memory: new base records, the
  // waiting halves and their table, hubs, and scratch memory for each thread.
  constexpr bool keeps_level_1 = Rule::kRingCount == 2;
  const std::uint64_t level_1 = keeps_level_1 ? edges * sizeof(Vector3<Real>) : 0,
                      for_level_1 = keeps_level_1 ? edges * (2 * sizeof(Vector3<Real>) + 48) : 0;
  const std::uint64_t pass_bytes =
      vertices * sizeof(Vector3<Real>) * (options.limit ? 2 : 1) +
      (here.after - here.first) * sizeof(void*) +
      fused_needs(store, std::span(records).first(options.normals ? 2 : 1), options.levels,
                  options.threads)
          .resident +
      BaseRings<Rule>::hub_bytes(store.base(), levels) +
      static_cast<std::uint64_t>(options.threads) *
          surface_scratch_bytes<Real>(levels, Rule::kRingCount) +
      sizeof(std::uint32_t) * vertices;
  return level_1 + std::max(for_level_1, pass_bytes);
}

template void run_fused(SubdivisionRun<float>&, const OneRing<float>&, AttributeId);
template void run_fused(SubdivisionRun<double>&, const OneRing<double>&, AttributeId);
template void run_fused(SubdivisionRun<float>&, const Butterfly<float>&, AttributeId);
template void run_fused(SubdivisionRun<double>&, const Butterfly<double>&, AttributeId);
template std::uint64_t fused_resident_bytes<OneRing<float>>(const Store&, const SubdivideOptions&);
template std::uint64_t fused_resident_bytes<OneRing<double>>(const Store&, const SubdivideOptions&);
template std::uint64_t fused_resident_bytes<Butterfly<float>>(const Store&,
                                                              const SubdivideOptions&);
template std::uint64_t fused_resident_bytes<Butterfly<double>>(const Store&,
                                                               const SubdivideOptions&);

PLAIT_END_NAMESPACE
