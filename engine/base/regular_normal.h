// base/regular_normal.h: the unit normal of a Loop surface at a vertex with six neighbours, or
// with four on a border: at every vertex that is no base vertex. The kernels compute normals by it,
// and the filter `normals` predicts them by it, so both get the same bits.
//
// Interior: t1 = sum cos(2 pi i/6) p_i, t2 = sum sin(2 pi i/6) p_i (C. Loop, "Smooth Subdivision
// Surfaces Based on Triangles", 1987). These are combinations of the differences of opposite
// neighbours, so rotating the ring by 180 degrees does not change any bit. Border: the mask (-2,
// -1, 2, 2, -1) across it (H. Hoppe et al., "Piecewise Smooth Surface Reconstruction", 1994).
// Pinned by tests/kernels/normals_test.cpp.
#pragma once

#include <algorithm>
#include <cmath>

#include "plait/detail/namespace.h"
#include "plait/extend/vector3.h"

PLAIT_BEGIN_NAMESPACE

/// All functions are safe from any thread and never fail.
struct RegularNormal {
  /// Whether the square of a length is far from the smallest and the largest float.
  template <class Real>
  static constexpr bool comfortable(Real square) {
    return square > Real(1e-30) && square < Real(1e30);
  }

  /// direction() of `v`. REQUIRES: `square` is dot(v, v), and comfortable(square).
  template <class Real>
  static Vector3<float> scaled_to_unit(Vector3<Real> v, Real square) {
    const Real scale = Real(1) / std::sqrt(square);
    return Vector3<float>{float(scale * v.x), float(scale * v.y), float(scale * v.z)} +
           positive_zeros();
  }

  /// The direction of cross(a, b), in float32. If the square of its length is not comfortable()
  /// (the units of the mesh are very small or very large), the length is computed in double, and so
  /// is the product, of scaled vectors, if it leaves the range of Real. Zeros are made positive: a
  /// ring rotated by 180 degrees would give them the other sign, but the result must not depend on
  /// the face that evaluates the vertex. Pinned by tests/acceptance/flat_surface_test.cpp.
  template <class Real>
  static Vector3<float> direction_of_cross(Vector3<Real> a, Vector3<Real> b) {
    const Vector3<Real> v = cross(a, b);
    const Real square = dot(v, v);
    return comfortable(square) ? scaled_to_unit(v, square) : careful_direction(a, b, v);
  }

  /// The normal of a regular vertex, from the differences of opposite neighbours: p_0 - p_3,
  /// p_1 - p_4, p_2 - p_5.
  template <class Real>
  static Vector3<float> interior(Vector3<Real> d0, Vector3<Real> d1, Vector3<Real> d2) {
    return direction_of_cross(d0 + Real(0.5) * (d1 - d2), d1 + d2);
  }

  /// The same for a border vertex with three faces: neighbours p_1 .. p_4, counterclockwise from
  /// border to border.
  template <class Real>
  static Vector3<float> border(Vector3<Real> v, Vector3<Real> p1, Vector3<Real> p2,
                               Vector3<Real> p3, Vector3<Real> p4) {
    const Vector3<Real> across = Real(2) * ((p2 - v) + (p3 - v)) - ((p1 - v) + (p4 - v));
    return direction_of_cross(p1 - p4, across);
  }

 private:
  static double largest_of(Vector3<double> v) {
    return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
  }
  /// By a power of two, so that the largest number is between 1 and 2.
  static Vector3<double> scaled(Vector3<double> v, double largest) {
    if (!(largest > 0) || !std::isfinite(largest)) return v;
    const int exponent = std::ilogb(largest);
    return {std::scalbn(v.x, -exponent), std::scalbn(v.y, -exponent), std::scalbn(v.z, -exponent)};
  }
  /// direction_of_cross() for a product `v` that is not comfortable().
  template <class Real>
  [[gnu::noinline, gnu::cold]] static Vector3<float> careful_direction(Vector3<Real> a,
                                                                       Vector3<Real> b,
                                                                       Vector3<Real> v) {
    // Between these bounds neither the products nor the square of the length, which is computed in
    // double, overflow or lose digits.
    constexpr double kLeast = sizeof(Real) == sizeof(float) ? 1e-36 : 1e-140,
                     kMost = sizeof(Real) == sizeof(float) ? 1e36 : 1e150;
    const Vector3<double> wide_a{a.x, a.y, a.z}, wide_b{b.x, b.y, b.z};
    const double largest_a = largest_of(wide_a), largest_b = largest_of(wide_b),
                 bound = largest_a * largest_b;
    const Vector3<double> unit =
        normalized(bound > kLeast && bound < kMost
                       ? Vector3<double>{v.x, v.y, v.z}
                       : cross(scaled(wide_a, largest_a), scaled(wide_b, largest_b)));
    return Vector3<float>{float(unit.x), float(unit.y), float(unit.z)} + positive_zeros();
  }
  static constexpr Vector3<float> positive_zeros() { return {0, 0, 0}; }  // -0 + 0 = 0
};

PLAIT_END_NAMESPACE
