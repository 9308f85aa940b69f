// Rows of a slot evaluated in registers: the bits of the rules of one vertex. (Those are compared
// with plain arithmetic in fused_rows_test.cpp and with the oracle in schemes_test.cpp.)
#include <catch2/catch.hpp>
#include <cstring>
#include <random>
#include <vector>

#include "normals/normal_rows.h"
#include "normals/normal_rules.h"
#include "plait/detail/edge_grid.h"
#include "plait/detail/one_ring.h"

using namespace plait;

namespace {

constexpr int kGridLevel = 4;

template <class Real>
EdgeGrid<Vector3<Real>> random_grid(unsigned seed, Real unit) {
  EdgeGrid<Vector3<Real>> grid;
  grid.resize(kGridLevel);
  std::mt19937 random(seed);
  // Few values, so that equal pairs and vanishing differences come up too.
  std::uniform_int_distribution<int> value(-4, 4);
  for (std::int64_t p = -1; p <= grid.size() + 1; ++p)
    for (std::int64_t q = -1; q <= grid.size() + 1; ++q)
      *grid.at(p, q) = {unit * Real(value(random)) / 3, unit * Real(value(random)) / 7,
                        unit * Real(value(random)) / 5};
  return grid;
}

template <class Real>
bool same_row_bits(const Vector3<Real>& a, const Vector3<Real>& b) {
  return std::memcmp(&a, &b, sizeof(a)) == 0;
}

/// The slots of an inner edge: whole; half or absent, where its faces have different depths. Then
/// the slot of a border edge.
constexpr SlotRows kEverySlot[] = {{SlotShape::kWhole, false},
                                   {SlotShape::kHalf, false},
                                   {SlotShape::kAbsent, false},
                                   {SlotShape::kHalf, true}};

/// Slots of every level and shape, of a few grids: rows(grid, level, kind, slot) against rule(value
/// before, vertex in the grid, stride, on the border).
template <class Real, class Value, class Rows, class Rule>
void check_rows(Real unit, Rows rows, Rule rule) {
  for (unsigned seed = 0; seed < 8; ++seed) {
    const EdgeGrid<Vector3<Real>> grid = random_grid(seed, unit);
    for (int level = 1; level <= kGridLevel; ++level)
      for (const SlotRows& kind : kEverySlot) {
        // A guard behind the slot: rows must not write more than they have.
        std::vector<Vector3<Value>> slot(slot_records(level, kind.shape) + 1);
        for (std::size_t i = 0; i < slot.size(); ++i)
          slot[i] = {Value(i) / 3, Value(1), Value(i % 5)};
        const std::vector<Vector3<Value>> before = slot;
        rows(grid, level, kind, slot.data());
        std::size_t next = 0;
        bool same = true;
        const std::int64_t n = slot_side(level), scale = std::int64_t{1} << (kGridLevel - level);
        for (std::int64_t row = 0; row < n; ++row)
          for (std::int64_t column = 0; column < kind.records(n, row); ++column, ++next)
            same &= same_row_bits<Value>(
                slot[next],
                rule(before[next], grid.at((2 * row + 1) * scale, (2 * column + 1) * scale),
                     grid.stride(), kind.border && row + column == n - 1));
        same &= same_row_bits<Value>(slot[next], before[next]);
        CHECK(same);
      }
  }
}

template <class Real>
const OneRing<Real>& loop() {
  return loop_scheme().rule<Real>();
}

template <class Real>
Vector3<Real> sum_at(const Vector3<Real>* v, std::int64_t stride) {
  return ring_sum(v[stride], v[1], v[1 - stride], v[-stride], v[-1], v[stride - 1]);
}

template <class Real>
Vector3<Real> moved(const Vector3<Real>& before, const Vector3<Real>* v, std::int64_t stride,
                    bool on_border) {
  if (on_border) return loop<Real>().even_border(before, v[1 - stride], v[stride - 1]);
  return loop<Real>().even(before, sum_at(v, stride));
}

template <class Real>
Vector3<Real> limit_of(const Vector3<Real>&, const Vector3<Real>* v, std::int64_t stride,
                       bool on_border) {
  if (on_border) return loop<Real>().limit_border(*v, v[1 - stride], v[stride - 1]);
  return loop<Real>().limit(*v, sum_at(v, stride));
}

template <class Real>
Vector3<float> normal_of(const Vector3<float>&, const Vector3<Real>* v, std::int64_t stride,
                         bool on_border) {
  if (on_border) return RegularNormal::border(*v, v[1 - stride], v[-stride], v[-1], v[stride - 1]);
  return normals::regular(v[stride] - v[-stride], v[1] - v[-1], v[1 - stride] - v[stride - 1]);
}

}  // namespace

TEMPLATE_TEST_CASE("EvenSlot_RowByRow_HasTheBitsOfTheRule", "", float, double) {
  check_rows<TestType, TestType>(
      1,
      [](const auto& grid, int level, const SlotRows& kind, auto* slot) {
        loop<TestType>().even_slot(grid, level, kind, slot);
      },
      moved<TestType>);
}

// The slot at the level after the grid's own.
TEMPLATE_TEST_CASE("OddSlot_RowByRow_HasTheBitsOfTheRule", "", float, double) {
  using Point = Vector3<TestType>;
  for (unsigned seed = 0; seed < 8; ++seed)
    for (const SlotRows& kind : kEverySlot) {
      const EdgeGrid<Point> grid = random_grid(seed, TestType(1));
      const std::int64_t n = grid.size();
      std::vector<Point> slot(slot_records(kGridLevel + 1, kind.shape) + 1, Point{1, 2, 3});
      loop<TestType>().odd_slot(grid, kind, slot.data());
      std::size_t next = 0;
      bool same = true;
      for (std::int64_t row = 0; row < n; ++row)
        for (std::int64_t column = 0; column < kind.records(n, row); ++column, ++next) {
          const Point &a = *grid.at(row, column + 1), &b = *grid.at(row + 1, column);
          same &=
              same_row_bits(slot[next], kind.border && row + column == n - 1
                                            ? loop<TestType>().odd_border(a, b)
                                            : loop<TestType>().odd(a, b, *grid.at(row, column),
                                                                   *grid.at(row + 1, column + 1)));
        }
      CHECK(same);
      CHECK(slot[next] == Point{1, 2, 3});
    }
}

TEMPLATE_TEST_CASE("LimitSlot_RowByRow_HasTheBitsOfTheRule", "", float, double) {
  check_rows<TestType, TestType>(
      1,
      [](const auto& grid, int level, const SlotRows& kind, auto* slot) {
        loop<TestType>().limit_slot(grid, level, kind, slot);
      },
      limit_of<TestType>);
}

TEMPLATE_TEST_CASE("NormalSlot_RowByRow_HasTheBitsOfTheRule", "", float, double) {
  // From units whose squares leave float's range to ones whose squares fill it.
  for (const double unit : {1e-30, 1e-9, 1.0, 1e6, 1e12})
    check_rows<TestType, float>(TestType(unit), normals::slot_rows<TestType>, normal_of<TestType>);
}
