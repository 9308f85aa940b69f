// Refines a group of patches by the modified Butterfly scheme, level by level. Its stencils reach
// two steps. So there are two rows of neighbouring points around each patch, and the corners have
// two rings.
#include <cstddef>
#include <cstdint>
#include <memory>

#include "butterfly/stencils.h"
#include "fused/patch_lattice.h"
#include "fused/surface_refiner.h"
#include "plait/detail/numbers.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

using namespace lattice_points;

template <class Real>
class ButterflyRefiner final : public SurfaceRefiner<Butterfly<Real>> {
 public:
  using SurfaceRefiner<Butterfly<Real>>::SurfaceRefiner;

 private:
  void refine_level(int level, std::size_t first, std::size_t count) override {
    continue_beyond_borders(level - 1, first, count);
    keep_even(level);
    make_odd(level);
    odd_borders(level, first, count);
    this->inject(level, count);
  }

  void continue_beyond_borders(int level, std::size_t first, std::size_t count);
  void keep_even(int level);
  void make_odd(int level);
  void odd_borders(int level, std::size_t first, std::size_t count);

  const Real* from(int level, std::int64_t i, std::int64_t j) const {
    return at(static_cast<const Real*>(this->coarse_.data()), this->lattice(level - 1), i, j);
  }
  Real* to(int level, std::int64_t i, std::int64_t j) const {
    return at(this->fine_.data(), this->lattice(level), i, j);
  }
};

/// Fills the points beyond borders in coarse_, which contains `level`.
template <class Real>
void ButterflyRefiner<Real>::continue_beyond_borders(int level, std::size_t first,
                                                     std::size_t count) {
  const PatchLattice lattice = this->lattice(level);
  const auto point = [&](const FaceIndex& p) {
    return at(this->coarse_.data(), lattice, p.i, p.j);
  };
  this->for_each_border(first, count, [&](std::size_t lane, int side) {
    const LatticeStep inwards = step(side, (side + 1) % 3);
    for (std::int64_t t = 0; t < lattice.size; ++t) {
      const FaceIndex a = on_side(level, side, t), b = on_side(level, side, t + 1),
                      inside{0, level, b.i + inwards.i, b.j + inwards.j},
                      beyond{0, level, a.i - inwards.i, a.j - inwards.j};
      put(point(beyond), lane,
          butterfly::continued(get(point(a), lane), get(point(b), lane), get(point(inside), lane)));
    }
  });
}

template <class Real>
void ButterflyRefiner<Real>::keep_even(int level) {
  const std::int64_t n = this->lattice(level - 1).size;
  for (std::int64_t q = -1; q <= n; ++q)
    this->rule().rows.even({from(level, -1, q), {}, to(level, -2, 2 * q), n - q + 3});
}

template <class Real>
void ButterflyRefiner<Real>::make_odd(int level) {
  const std::int64_t n = this->lattice(level - 1).size;
  for (std::int64_t q = -1; q <= n; ++q) {
    const std::int64_t count = n - q + 2;
    const auto row = [&](std::int64_t i, std::int64_t j) { return from(level, i, q + j); };
    // The middles of the edges along the coarse row.
    this->rule().rows.odd({row(-1, 0), row(0, 0), row(-1, 1), row(0, -1), row(-2, 1), row(1, -1),
                           row(0, 1), row(-1, -1), to(level, -1, 2 * q), count});
    // The middles of the edges that go up from the coarse row, in both directions.
    this->rule().rows.odd({row(-1, 0), row(-1, 1), row(-2, 1), row(0, 0), row(-2, 0), row(0, 1),
                           row(-2, 2), row(0, -1), to(level, -2, 2 * q + 1), count});
    this->rule().rows.odd({row(0, 0), row(-1, 1), row(-1, 0), row(0, 1), row(0, -1), row(-1, 2),
                           row(-2, 1), row(1, 0), to(level, -1, 2 * q + 1), count});
  }
}

/// Computes odd vertices on borders. Those next to corners come from the rings of the corners.
template <class Real>
void ButterflyRefiner<Real>::odd_borders(int level, std::size_t first, std::size_t count) {
  const std::int64_t n = this->lattice(level - 1).size;
  this->for_each_border(first, count, [&](std::size_t lane, int side) {
    const auto old = [&](std::int64_t t) {
      const FaceIndex p = on_side(level - 1, side, t);
      return get(from(level, p.i, p.j), lane);
    };
    for (std::int64_t t = 1; t + 2 <= n; ++t) {
      const FaceIndex middle = on_side(level, side, 2 * t + 1);
      put(to(level, middle.i, middle.j), lane,
          butterfly::odd_border(old(t - 1), old(t), old(t + 1), old(t + 2)));
    }
  });
}

}  // namespace

template <class Real>
std::unique_ptr<PatchRefiner> make_refiner(const SurfaceRefinement<Butterfly<Real>>& refinement) {
  return std::make_unique<ButterflyRefiner<Real>>(refinement);
}

template std::unique_ptr<PatchRefiner> make_refiner(const SurfaceRefinement<Butterfly<float>>&);
template std::unique_ptr<PatchRefiner> make_refiner(const SurfaceRefinement<Butterfly<double>>&);

PLAIT_END_NAMESPACE
