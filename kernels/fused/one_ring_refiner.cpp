// Refines a group of patches by a one-ring rule, level by level.
#include <memory>

#include "fused/patch_lattice.h"
#include "fused/surface_refiner.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

using namespace lattice_points;

template <class Real>
class OneRingRefiner final : public SurfaceRefiner<OneRing<Real>> {
 public:
  using SurfaceRefiner<OneRing<Real>>::SurfaceRefiner;

 private:
  void refine_level(int level, std::size_t first, std::size_t count) override {
    make_odd(level);
    odd_borders(level, first, count);
    this->inject(level, count);
    move_even(level);
    if (this->rule().moves_even()) even_borders(level, first, count);
  }

  void make_odd(int level);
  void move_even(int level);
  void odd_borders(int level, std::size_t first, std::size_t count);
  void even_borders(int level, std::size_t first, std::size_t count);
};

template <class Real>
void OneRingRefiner<Real>::make_odd(int level) {
  const std::int64_t n = std::int64_t{1} << (level - 1);
  const PatchLattice coarse = this->lattice(level - 1), fine = this->lattice(level);
  const auto from = [&](std::int64_t i, std::int64_t j) {
    return static_cast<const Real*>(at(this->coarse_.data(), coarse, i, j));
  };
  const auto to = [&](std::int64_t i, std::int64_t j) {
    return at(this->fine_.data(), fine, i, j);
  };
  // Fine rows 2q: the middles of the edges along the coarse row.
  for (std::int64_t q = 0; q <= n; ++q)
    this->rule().odd_row(
        {from(-1, q), from(0, q), from(-1, q + 1), from(0, q - 1), to(-1, 2 * q), n - q + 2});
  // Fine rows 2q + 1: the middles of the edges that go up from the coarse row, in both directions.
  for (std::int64_t q = -1; q < n; ++q) {
    const std::int64_t first = q < 0 ? 1 : 0;
    this->rule().odd_row({from(first, q), from(first, q + 1), from(first - 1, q + 1),
                          from(first + 1, q), to(2 * first, 2 * q + 1), q < 0 ? n : n - q + 1});
    this->rule().odd_row({from(first, q), from(first - 1, q + 1), from(first - 1, q),
                          from(first, q + 1), to(2 * first - 1, 2 * q + 1), q < 0 ? n : n - q + 1});
  }
}

template <class Real>
void OneRingRefiner<Real>::move_even(int level) {
  const std::int64_t n = std::int64_t{1} << (level - 1);
  const PatchLattice coarse = this->lattice(level - 1), fine = this->lattice(level);
  for (std::int64_t q = 0; q < n; ++q) {
    const std::int64_t first = q == 0 ? 1 : 0, count = q == 0 ? n - 1 : n - q + 1;
    this->rule().even_row({at(static_cast<const Real*>(this->coarse_.data()), coarse, first, q),
                           neighbours<Real>(this->fine_.data(), fine, 2 * first, 2 * q, 2),
                           at(this->fine_.data(), fine, 2 * first, 2 * q), count});
  }
}

template <class Real>
void OneRingRefiner<Real>::odd_borders(int level, std::size_t first, std::size_t count) {
  const std::int64_t n = std::int64_t{1} << (level - 1);
  const PatchLattice coarse = this->lattice(level - 1), fine = this->lattice(level);
  this->for_each_border(first, count, [&](std::size_t lane, int side) {
    for (std::int64_t t = 0; t < n; ++t) {
      const FaceIndex a = on_side(level - 1, side, t), b = on_side(level - 1, side, t + 1),
                      middle = on_side(level, side, 2 * t + 1);
      put(at(this->fine_.data(), fine, middle.i, middle.j), lane,
          this->rule().odd_border(get(at(this->coarse_.data(), coarse, a.i, a.j), lane),
                                  get(at(this->coarse_.data(), coarse, b.i, b.j), lane)));
    }
  });
}

template <class Real>
void OneRingRefiner<Real>::even_borders(int level, std::size_t first, std::size_t count) {
  const std::int64_t n = std::int64_t{1} << (level - 1);
  const PatchLattice coarse = this->lattice(level - 1), fine = this->lattice(level);
  this->for_each_border(first, count, [&](std::size_t lane, int side) {
    for (std::int64_t t = 1; t < n; ++t) {
      const FaceIndex old = on_side(level - 1, side, t), a = on_side(level, side, 2 * t - 1),
                      here = on_side(level, side, 2 * t), b = on_side(level, side, 2 * t + 1);
      put(at(this->fine_.data(), fine, here.i, here.j), lane,
          this->rule().even_border(get(at(this->coarse_.data(), coarse, old.i, old.j), lane),
                                   get(at(this->fine_.data(), fine, a.i, a.j), lane),
                                   get(at(this->fine_.data(), fine, b.i, b.j), lane)));
    }
  });
}

}  // namespace

template <class Real>
std::unique_ptr<PatchRefiner> make_refiner(const SurfaceRefinement<OneRing<Real>>& refinement) {
  return std::make_unique<OneRingRefiner<Real>>(refinement);
}

template std::unique_ptr<PatchRefiner> make_refiner(const SurfaceRefinement<OneRing<float>>&);
template std::unique_ptr<PatchRefiner> make_refiner(const SurfaceRefinement<OneRing<double>>&);

PLAIT_END_NAMESPACE
