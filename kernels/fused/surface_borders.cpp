// Computes normals and limit positions along border edges. They replace the results of the rows
// there.
#include "fused/patch_lattice.h"
#include "fused/surface_refiner.h"
#include "normals/normal_rules.h"
#include "plait/detail/numbers.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

using namespace lattice_points;

template <class Rule>
void SurfaceRefiner<Rule>::surface_borders(std::size_t first, std::size_t count) {
  const bool normals = !refinement_.results.normals.empty(),
             limits = !refinement_.results.limits.empty();
  if (!normals && !limits) return;
  for_each_border(first, count, [&](std::size_t lane, int side) {
    const int start = (side + 1) % 3, end = (side + 2) % 3;
    for (std::int64_t t = 1; t < finest_.size; ++t) {
      const FaceIndex here = on_side(refinement_.source.levels, side, t);
      const auto near = [&](LatticeStep s) {
        return get(at(static_cast<const Real*>(fine_.data()), finest_, here.i + s.i, here.j + s.j),
                   lane);
      };
      const Vector3<Real> v = near({0, 0}), p1 = near(step(end, start)),
                          p4 = near(step(start, end));
      if (normals)
        put(at(normals_.data(), finest_, here.i, here.j), lane,
            RegularNormal::border(v, p1, near(step(side, start)), near(step(side, end)), p4));
      if constexpr (Rule::kRingCount == 1)
        if (limits)
          put(at(coarse_.data(), finest_, here.i, here.j), lane, rule().limit_border(v, p1, p4));
    }
  });
}

template void SurfaceRefiner<OneRing<float>>::surface_borders(std::size_t, std::size_t);
template void SurfaceRefiner<OneRing<double>>::surface_borders(std::size_t, std::size_t);
template void SurfaceRefiner<Butterfly<float>>::surface_borders(std::size_t, std::size_t);
template void SurfaceRefiner<Butterfly<double>>::surface_borders(std::size_t, std::size_t);

PLAIT_END_NAMESPACE
