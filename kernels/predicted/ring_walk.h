// Takes one vertex of each patch of a group, with its ring, from its level to the finest level.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

#include "fused/patch_lattice.h"
#include "normals/normal_rules.h"
#include "plait/detail/one_ring.h"
#include "plait/detail/rows.h"
#include "plait/extend/fused.h"
#include "rows/dispatched_rows.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// The vertex is not a base vertex, so it has six neighbours. On a border it has four, and the
/// numbers of the other two mean nothing.
template <class Real>
class RingWalk {
 public:
  /// A point of the lattice, and the lanes in which it lies on a border, all on the same side.
  struct Start {
    const Real* numbers;
    PatchLattice lattice;
    std::int64_t i, j;
    int side;  ///< of the slot to which the point belongs
    std::span<const std::uint8_t> border_lanes;
  };

  /// `rule` outlives this object.
  explicit RingWalk(const OneRing<Real>& rule) : rule_(rule) {}

  /// After the call, v() is the vertex `steps` levels finer.
  void walk(const Start& start, int steps) {
    start_ = start;
    v_ = lattice_points::at(start.numbers, start.lattice, start.i, start.j);
    for (std::size_t spoke = 0; spoke < kSpokes; ++spoke)
      ring_[spoke] = lattice_points::at(start.numbers, start.lattice, start.i + kSteps[spoke].i,
                                        start.j + kSteps[spoke].j);
    for (int step = 0; step < steps; ++step) refine(buffers_[static_cast<std::size_t>(step % 2)]);
  }
  /// 48 numbers, as all results. Valid until the next call.
  const Real* v() const { return v_; }

  const Real* limit() {
    Real* const to = result_.data();
    rule_.limit_row({v_, neighbours(), to, 1, 1});
    const auto [p, q] = along_border();
    for (const std::uint8_t lane : start_.border_lanes)
      lattice_points::put(
          to, lane, rule_.limit_border(get(v_, lane), get(ring_[p], lane), get(ring_[q], lane)));
    return to;
  }

  const float* normal() {
    float* const to = normal_.data();
    normal_row_({v_, neighbours(), to, 1, 1});
    const int side = start_.side, start = (side + 1) % 3, end = (side + 2) % 3;
    const auto [p, q] = along_border();
    for (const std::uint8_t lane : start_.border_lanes)
      lattice_points::put(
          to, lane,
          RegularNormal::border(get(v_, lane), get(ring_[p], lane),
                                get(ring_[spoke(side, start)], lane),
                                get(ring_[spoke(side, end)], lane), get(ring_[q], lane)));
    return to;
  }

 private:
  static constexpr std::size_t kSpokes = 6;
  /// Counterclockwise.
  static constexpr LatticeStep kSteps[kSpokes] = {{1, 0},  {0, 1},  {-1, 1},
                                                  {-1, 0}, {0, -1}, {1, -1}};

  struct Buffer {
    alignas(64) std::array<Real, (kSpokes + 1) * kPointNumbers> numbers;
    Real* point(std::size_t number) { return numbers.data() + number * kPointNumbers; }
  };

  static Vector3<Real> get(const Real* point, std::size_t lane) {
    return lattice_points::get(point, lane);
  }
  /// The spoke in the direction of one corner from another.
  static std::size_t spoke(int to, int from) {
    const LatticeStep wanted = step(to, from);
    std::size_t found = 0;
    while (kSteps[found].i != wanted.i || kSteps[found].j != wanted.j) ++found;
    return found;
  }
  /// The spokes along the side of the point.
  std::pair<std::size_t, std::size_t> along_border() const {
    const int start = (start_.side + 1) % 3, end = (start_.side + 2) % 3;
    return {spoke(end, start), spoke(start, end)};
  }
  /// In the order of the frame of the point's side, as neighbours() of the lattice.
  Neighbours<Real> neighbours() const {
    const int start = (start_.side + 1) % 3, end = (start_.side + 2) % 3;
    Neighbours<Real> result;
    const auto pair = [&](std::size_t ahead, std::size_t which) {
      result.pairs[which][0] = ring_[ahead];
      result.pairs[which][1] = ring_[(ahead + kSpokes / 2) % kSpokes];
    };
    pair(spoke(start, start_.side), 0);
    pair(spoke(end, start_.side), 1);
    pair(spoke(end, start), 2);
    return result;
  }

  void refine(Buffer& to) {
    std::array<const Real*, kSpokes> next;
    for (std::size_t spoke = 0; spoke < kSpokes; ++spoke) {
      Real* const made = to.point(1 + spoke);
      rule_.odd_row({v_, ring_[spoke], ring_[(spoke + kSpokes - 1) % kSpokes],
                     ring_[(spoke + 1) % kSpokes], made, 1});
      next[spoke] = made;
    }
    const auto [p, q] = along_border();
    for (const std::uint8_t lane : start_.border_lanes)
      for (const std::size_t spoke : {p, q})
        lattice_points::put(to.point(1 + spoke), lane,
                            rule_.odd_border(get(v_, lane), get(ring_[spoke], lane)));
    ring_ = next;
    if (!rule_.moves_even()) return;
    rule_.even_row({v_, neighbours(), to.point(0), 1});
    for (const std::uint8_t lane : start_.border_lanes)
      lattice_points::put(
          to.point(0), lane,
          rule_.even_border(get(v_, lane), get(ring_[p], lane), get(ring_[q], lane)));
    v_ = to.point(0);
  }

  const OneRing<Real>& rule_;
  NormalRow<Real> normal_row_ = plait::normal_row<Real>();
  Start start_{};
  const Real* v_ = nullptr;
  std::array<const Real*, kSpokes> ring_{};
  std::array<Buffer, 2> buffers_;
  alignas(64) std::array<Real, kPointNumbers> result_;
  alignas(64) std::array<float, kPointNumbers> normal_;
};

PLAIT_END_NAMESPACE
