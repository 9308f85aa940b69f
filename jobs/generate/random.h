// generate/random.h: random numbers that are the same on every machine. The C++ standard defines
// the engine bit by bit, but not the distributions, so the distributions are our own.
#pragma once

#include <cstdint>
#include <random>

#include "plait/extend/vector3.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace generation {

/// A bijection of 64-bit words whose results look random.
/// Source: G. Steele, D. Lea, C. Flood, "Fast splittable pseudorandom number generators" (2014).
constexpr std::uint64_t mix(std::uint64_t word) {
  word += 0x9e3779b97f4a7c15u;
  word = (word ^ (word >> 30)) * 0xbf58476d1ce4e5b9u;
  word = (word ^ (word >> 27)) * 0x94d049bb133111ebu;
  return word ^ (word >> 31);
}

/// The upper 53 bits of a word as a number in [0, 1).
constexpr double to_unit(std::uint64_t word) { return static_cast<double>(word >> 11) * 0x1p-53; }

class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(mix(seed)) {}

  double unit() { return to_unit(engine_()); }
  double between(double low, double high) { return low + (high - low) * unit(); }

  /// Uniform on the unit sphere.
  Vector3<double> direction() {
    for (;;) {
      const double x = between(-1, 1);
      const double y = between(-1, 1);
      const double z = between(-1, 1);
      const Vector3<double> inside{x, y, z};
      const double length2 = dot(inside, inside);
      if (length2 <= 1 && length2 > 0.01) return normalized(inside);
    }
  }

 private:
  std::mt19937_64 engine_;
};

}  // namespace generation
PLAIT_END_NAMESPACE
