// plait/extend/vector3.h: three numbers with vector arithmetic. Programs read and write float32 x 3
// and float64 x 3 records as this type.
//
// dot(), cross() and normalized() are always inlined. A program's compiler may contract a
// multiplication and an addition into one rounding; if the functions had linkable copies, the
// linker could replace the library's copy by the program's. The operators do one operation per
// component, so they give the same result under any flags.
#pragma once

#include <cmath>

#include "plait/detail/namespace.h"

#ifdef __FAST_MATH__
#error "plait promises the same bits in every build: compile this source without -ffast-math"
#endif

PLAIT_BEGIN_NAMESPACE

/// Three numbers: a position, a difference of positions, or a normal.
template <class Real>
struct Vector3 {
  Real x, y, z;

  friend constexpr bool operator==(const Vector3&, const Vector3&) = default;
  constexpr Real& operator[](int axis) { return axis == 0 ? x : axis == 1 ? y : z; }
  constexpr const Real& operator[](int axis) const { return axis == 0 ? x : axis == 1 ? y : z; }
  friend constexpr Vector3 operator+(Vector3 a, Vector3 b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
  }
  friend constexpr Vector3 operator-(Vector3 a, Vector3 b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
  }
  friend constexpr Vector3 operator*(Real s, Vector3 a) { return {s * a.x, s * a.y, s * a.z}; }
};

template <class Real>
[[gnu::always_inline]] constexpr Real dot(Vector3<Real> a, Vector3<Real> b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

template <class Real>
[[gnu::always_inline]] constexpr Vector3<Real> cross(Vector3<Real> a, Vector3<Real> b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// `a` divided by its length. The zero vector stays zero.
template <class Real>
[[gnu::always_inline]] inline Vector3<Real> normalized(Vector3<Real> a) {
  const Real length = std::sqrt(dot(a, a));
  return length > Real(0) ? Vector3<Real>{a.x / length, a.y / length, a.z / length} : a;
}

PLAIT_END_NAMESPACE
