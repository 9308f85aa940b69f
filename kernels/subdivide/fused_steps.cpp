#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include "fused/surface_refiner.h"
#include "plait/fused.h"
#include "subdivide/steps.h"

namespace plait {
namespace {

FusedPass fused_pass(int levels, AttributeId position, AttributeId normal) {
  FusedPass pass;
  pass.name = "subdivision";
  pass.outputs = {position};
  if (normal != kNoId) pass.outputs.push_back(normal);
  pass.levels = levels;
  pass.lattice = {std::int64_t{1} << levels, 1};
  return pass;
}

}  // namespace

template <class Real>
void run_fused(SubdivisionRun<Real>& run, int levels, AttributeId normal) {
  Store& store = run.store;
  const SubdivideOptions& options = run.options;
  const std::span<Vector3<Real>> base = store.base_records<Vector3<Real>>(run.position);
  // The base mesh is read until the last patch is done.
  std::vector<Vector3<Real>> positions(base.size()), limits(options.limit ? base.size() : 0);

  SurfaceRefinement<Real> refinement;
  refinement.mesh = store.base().topology();
  refinement.base = base;
  refinement.levels = levels;
  refinement.rows = options.scheme == Scheme::kLoop ? loop_rows<Real>() : midpoint_rows<Real>();
  refinement.results = {positions, limits, {}};
  if (normal != kNoId) refinement.results.normals = store.base_records<Vector3<float>>(normal);

  FusedPass pass = fused_pass(levels, run.position, normal);
  pass.make_refiner = [&] { return std::make_unique<SurfaceRefiner<Real>>(refinement); };
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
  const int levels = options.levels - store.base_level();
  const FusedPass pass =
      fused_pass(levels, store.attribute("position"),
                 store.has_attribute("normal") ? store.attribute("normal") : kNoId);
  // New base records, the halves that wait and where, and what each thread works in.
  return vertices * sizeof(Vector3<Real>) * (options.limit ? 2 : 1) + edges * sizeof(void*) +
         fused_needs(store, pass, options.threads).slot_bytes +
         static_cast<std::uint64_t>(options.threads) *
             (SurfaceRefiner<Real>::scratch_bytes(levels) + sizeof(std::uint32_t) * vertices);
}

template void run_fused(SubdivisionRun<float>&, int, AttributeId);
template void run_fused(SubdivisionRun<double>&, int, AttributeId);
template std::uint64_t fused_resident_bytes<float>(const Store&, const SubdivideOptions&);
template std::uint64_t fused_resident_bytes<double>(const Store&, const SubdivideOptions&);

}  // namespace plait
