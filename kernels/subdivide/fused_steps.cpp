#include <algorithm>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "butterfly/base_middles.h"
#include "fused/builtin_rows.h"
#include "fused/surface_refiner.h"
#include "plait/base_relative_level.h"
#include "plait/error.h"
#include "plait/fused.h"
#include "subdivide/steps.h"

namespace plait {
namespace {

int reach(Scheme scheme) { return scheme == Scheme::kButterfly ? 2 : 1; }

BaseRelativeLevel finest(const Store& store, const SubdivideOptions& options) {
  return relative_to_base(options.levels, store.base_level());
}

FusedPass fused_pass(const Store& store, const SubdivideOptions& options, AttributeId position,
                     AttributeId normal) {
  FusedPass pass;
  pass.name = "subdivision";
  pass.outputs = {position};
  if (normal != kNoId) pass.outputs.push_back(normal);
  pass.finest_level = options.levels;
  pass.lattice = surface_lattice(finest(store, options).refinements, reach(options.scheme));
  return pass;
}

/// Of every scheme, what fans need.
template <class Real>
fused_rows::PatchRows<Real> rows_of(Scheme scheme) {
  switch (scheme) {
    case Scheme::kLoop:
      return loop_rows<Real>();
    case Scheme::kMidpoint:
      return midpoint_rows<Real>();
    case Scheme::kButterfly:
      return butterfly_rows<Real>();
  }
  throw Error(ErrorCode::kInvalidArgument, "subdivide: unknown scheme");
}

template <class Real>
std::unique_ptr<PatchRefiner> make_refiner(Scheme scheme,
                                           const SurfaceRefinement<Real>& refinement) {
  switch (scheme) {
    case Scheme::kLoop:
      return one_ring_refiner(refinement, loop_rows<Real>());
    case Scheme::kMidpoint:
      return one_ring_refiner(refinement, midpoint_rows<Real>());
    case Scheme::kButterfly:
      return butterfly_refiner(refinement, butterfly_rows<Real>());
  }
  throw Error(ErrorCode::kInvalidArgument, "subdivide: unknown scheme");
}

}  // namespace

template <class Real>
void run_fused(SubdivisionRun<Real>& run, AttributeId normal) {
  Store& store = run.store;
  const SubdivideOptions& options = run.options;
  const int levels = finest(store, options).refinements;
  const std::span<Vector3<Real>> base = store.base_records<Vector3<Real>>(run.position);
  // The base mesh is read until the last patch is done.
  std::vector<Vector3<Real>> positions(base.size()), limits(options.limit ? base.size() : 0);

  SurfaceRefinement<Real> refinement;
  refinement.source = {store.base().topology(), base, levels, reach(options.scheme)};
  refinement.results = {positions, limits, {}};
  if (normal != kNoId) refinement.results.normals = store.base_records<Vector3<float>>(normal);
  std::vector<Vector3<Real>> middles;
  if (options.scheme == Scheme::kButterfly) {
    middles = butterfly::base_middles(refinement.source.mesh, refinement.source.base);
    refinement.source.middles = middles;
  }

  Fans<Real> hubs(refinement.source, rows_of<Real>(options.scheme));
  hubs.evaluate_hubs();
  refinement.source.hubs = &hubs;

  FusedPass pass = fused_pass(store, options, run.position, normal);
  pass.make_refiner = [&] { return make_refiner(options.scheme, refinement); };
  FusedOptions how;
  how.threads = options.threads;
  how.proceed = [&](std::uint64_t done, std::uint64_t count) {
    run.report("subdivision", run.vertices_total, done, count);
    return true;
  };
  fused(store, pass, how);
  std::ranges::copy(options.limit ? limits : positions, base.begin());
}

template <class Real>
std::uint64_t fused_resident_bytes(const Store& store, const SubdivideOptions& options) {
  const std::uint64_t vertices = store.base().vertex_count(), edges = store.base().edge_count();
  const int levels = finest(store, options).refinements;
  const FusedPass pass =
      fused_pass(store, options, store.attribute("position"),
                 store.has_attribute("normal") ? store.attribute("normal") : kNoId);
  // Butterfly's level 1 stays; rings and values in double, from which it is made, are given back
  // before the pass takes what it needs: new base records, the halves that wait and where, hubs,
  // and what each thread works in.
  const bool butterfly = options.scheme == Scheme::kButterfly;
  const std::uint64_t level_1 = butterfly ? edges * sizeof(Vector3<Real>) : 0,
                      for_level_1 = butterfly ? edges * (2 * sizeof(Vector3<Real>) + 48) : 0;
  const std::uint64_t pass_bytes =
      vertices * sizeof(Vector3<Real>) * (options.limit ? 2 : 1) + edges * sizeof(void*) +
      fused_needs(store, pass, options.threads).slot_bytes +
      Fans<Real>::hub_bytes(store.base().topology(), levels, reach(options.scheme)) +
      static_cast<std::uint64_t>(options.threads) *
          (surface_scratch_bytes<Real>(levels, reach(options.scheme)) +
           sizeof(std::uint32_t) * vertices) +
      sizeof(std::uint32_t) * vertices;
  return level_1 + std::max(for_level_1, pass_bytes);
}

template void run_fused(SubdivisionRun<float>&, AttributeId);
template void run_fused(SubdivisionRun<double>&, AttributeId);
template std::uint64_t fused_resident_bytes<float>(const Store&, const SubdivideOptions&);
template std::uint64_t fused_resident_bytes<double>(const Store&, const SubdivideOptions&);

}  // namespace plait
