// Rows of a slot evaluated on vector lanes: the bits of the scalar rules, vertex by vertex.
#include <catch2/catch.hpp>
#include <cstring>
#include <random>
#include <vector>

#include "diamond/diamond.h"
#include "loop/loop_diamond.h"
#include "loop/loop_expressions.h"
#include "normals/normal_rows.h"
#include "normals/normal_rules.h"

using namespace plait;

namespace {

constexpr int kGridLevel = 4;

template <class Real>
Diamond<Vector3<Real>> random_diamond(unsigned seed, Real unit) {
  Diamond<Vector3<Real>> diamond;
  diamond.resize(kGridLevel);
  std::mt19937 random(seed);
  // Few values, so that equal pairs and vanishing differences come up too.
  std::uniform_int_distribution<int> value(-4, 4);
  for (std::int64_t p = -1; p <= diamond.size() + 1; ++p)
    for (std::int64_t q = -1; q <= diamond.size() + 1; ++q)
      *diamond.at(p, q) = {unit * Real(value(random)) / 3, unit * Real(value(random)) / 7,
                           unit * Real(value(random)) / 5};
  return diamond;
}

template <class Real>
bool same_bits(const Vector3<Real>& a, const Vector3<Real>& b) {
  return std::memcmp(&a, &b, sizeof(a)) == 0;
}

/// Slots of every level, interior and border, of a few diamonds: rows(diamond, level, border, slot)
/// against rule(value before, vertex in the grid, stride, on the border).
template <class Real, class Value, class Rows, class Rule>
void check_rows(Real unit, Rows rows, Rule rule) {
  for (unsigned seed = 0; seed < 8; ++seed) {
    const Diamond<Vector3<Real>> diamond = random_diamond(seed, unit);
    for (int level = 1; level <= kGridLevel; ++level)
      for (const bool border : {false, true}) {
        // A guard behind the slot: rows must not write more than they have.
        std::vector<Vector3<Value>> slot(slot_records(level, border) + 1);
        for (std::size_t i = 0; i < slot.size(); ++i)
          slot[i] = {Value(i) / 3, Value(1), Value(i % 5)};
        const std::vector<Vector3<Value>> before = slot;
        rows(diamond, level, border, slot.data());
        std::size_t next = 0;
        bool same = true;
        const std::int64_t n = slot_side(level), scale = std::int64_t{1} << (kGridLevel - level);
        for (std::int64_t row = 0; row < n; ++row)
          for (std::int64_t column = 0; column < (border ? n - row : n); ++column, ++next)
            same &= same_bits<Value>(
                slot[next],
                rule(before[next], diamond.at((2 * row + 1) * scale, (2 * column + 1) * scale),
                     diamond.stride(), border && row + column == n - 1));
        same &= same_bits<Value>(slot[next], before[next]);
        CHECK(same);
      }
  }
}

template <class Real>
Vector3<Real> moved(const Vector3<Real>& before, const Vector3<Real>* v, std::int64_t stride,
                    bool on_border) {
  if (on_border)
    return loop::by_axis<Real>(loop::even_border<Real>, before, v[1 - stride], v[stride - 1]);
  return loop::by_axis<Real>(loop::even<Real>, before, v[stride] + v[-stride], v[1] + v[-1],
                             v[1 - stride] + v[stride - 1]);
}

template <class Real>
Vector3<Real> limit_of(const Vector3<Real>&, const Vector3<Real>* v, std::int64_t stride,
                       bool on_border) {
  if (on_border)
    return loop::by_axis<Real>(loop::limit_border<Real>, *v, v[1 - stride], v[stride - 1]);
  return loop::by_axis<Real>(loop::limit<Real>, *v, v[stride] + v[-stride], v[1] + v[-1],
                             v[1 - stride] + v[stride - 1]);
}

template <class Real>
Vector3<float> normal_of(const Vector3<float>&, const Vector3<Real>* v, std::int64_t stride,
                         bool on_border) {
  if (on_border)
    return normals::regular_border(*v, v[1 - stride], v[-stride], v[-1], v[stride - 1]);
  return normals::regular(v[stride] - v[-stride], v[1] - v[-1], v[1 - stride] - v[stride - 1]);
}

}  // namespace

TEMPLATE_TEST_CASE("EvenSlot_RowByRow_HasTheBitsOfTheRule", "", float, double) {
  check_rows<TestType, TestType>(1, loop::even_slot<TestType>, moved<TestType>);
}

TEMPLATE_TEST_CASE("LimitSlot_RowByRow_HasTheBitsOfTheRule", "", float, double) {
  check_rows<TestType, TestType>(1, loop::limit_slot<TestType>, limit_of<TestType>);
}

TEMPLATE_TEST_CASE("NormalSlot_RowByRow_HasTheBitsOfTheRule", "", float, double) {
  // From units whose squares leave float's range to ones whose squares fill it.
  for (const double unit : {1e-30, 1e-9, 1.0, 1e6, 1e12})
    check_rows<TestType, float>(TestType(unit), normals::slot_rows<TestType>, normal_of<TestType>);
}
