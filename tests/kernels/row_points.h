// Points for the rows of the fused executor, and every instruction set to try them on.
#pragma once

#include <array>
#include <catch2/catch.hpp>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <random>
#include <vector>

#include "plait/detail/rows.h"
#include "plait/extend/vector3.h"
#include "rows/every_target.h"

namespace plait::test {

constexpr std::size_t kCount = 9;

/// Calls check() under each of them.
template <class Check>
void on_every_target(Check check) {
  int targets = 0;
  fused_rows::on_every_target([&](const char* name) {
    INFO(name);
    check();
    ++targets;
  });
  CHECK(targets > 0);
}

/// A number that is none has no bits of its own: which operand it comes from is not defined.
template <class Real>
bool same_bits(Real a, Real b) {
  return (a != a && b != b) || std::memcmp(&a, &b, sizeof a) == 0;
}

/// Points that rows read: [point][axis][lane], aligned as the rows' callers align them.
template <class Real>
struct Points {
  explicit Points(std::size_t count) : numbers(count * kPointNumbers + kAlign) {
    const auto at = reinterpret_cast<std::uintptr_t>(numbers.data());
    first = numbers.data() + (64 - at % 64) % 64 / sizeof(Real);
  }
  static constexpr std::size_t kAlign = 64 / sizeof(Real);
  Real* at(std::size_t point) { return first + point * kPointNumbers; }
  Vector3<Real> get(std::size_t point, std::size_t lane) {
    return {at(point)[lane], at(point)[kPatchLanes + lane], at(point)[2 * kPatchLanes + lane]};
  }
  std::vector<Real> numbers;
  Real* first;
};

/// Ordinary numbers of one size with zeros of both signs, equal values and, if asked for, numbers
/// that overflow, vanish or are none.
template <class Real>
void fill(Points<Real>& points, std::size_t count, unsigned seed, Real unit, bool wild) {
  using Limits = std::numeric_limits<Real>;
  const std::array<Real, 12> odd_ones = {
      Real(0),           -Real(0),           Limits::denorm_min(), -Limits::denorm_min(),
      Limits::min() / 2, Real(1e38),         Real(-1e38),          Limits::max(),
      Limits::lowest(),  Limits::infinity(), -Limits::infinity(),  Limits::quiet_NaN()};
  std::mt19937 random(seed);
  for (std::size_t i = 0; i < count * kPointNumbers; ++i) {
    const int value = static_cast<int>(random() % 9) - 4;
    points.first[i] = value == 0 ? (random() % 2 ? Real(0) : -Real(0)) : unit * Real(value) / 3;
    if (wild && random() % 12 == 0) points.first[i] = odd_ones[random() % odd_ones.size()];
  }
}

template <class Real>
struct Case {
  Real unit;
  bool wild;
};
template <class Real>
std::vector<Case<Real>> cases() {
  return {{Real(1), false},     {Real(1), true},     {Real(0), false},    {Real(1e-42), false},
          {Real(1e-20), false}, {Real(1e-8), false}, {Real(3e-8), false}, {Real(3e7), false},
          {Real(1e8), false},   {Real(1e19), true},  {Real(1e38), false}};
}

/// Calls check(points) for points of every kind.
template <class Real, class Check>
void for_all_points(std::size_t count, Check check) {
  unsigned seed = 0;
  for (const auto& [unit, wild] : cases<Real>())
    for (int turn = 0; turn < 6; ++turn) {
      Points<Real> points(count);
      fill(points, count, ++seed, unit, wild);
      INFO("unit " << unit << ", seed " << seed);
      check(points);
    }
}

}  // namespace plait::test
