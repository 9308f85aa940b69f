// collapse/quadric.h: squared distances to many planes and points, as one quadratic function (M.
// Garland and P. Heckbert, "Surface simplification using quadric error metrics", 1997).
#pragma once

#include "plait/detail/namespace.h"
#include "surface/surface.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// q(p) = p A p - 2 b p + c, with A symmetric. Pinned by tests/scans/collapse_history_test.cpp.
struct Quadric {
  double xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;
  Point b{0, 0, 0};
  double c = 0;

  /// Adds `weight` times the squared distance to the plane through `point`. `normal` has length 1.
  void add_plane(Point normal, Point point, double weight) {
    const double offset = dot(normal, point);
    xx += weight * normal.x * normal.x;
    xy += weight * normal.x * normal.y;
    xz += weight * normal.x * normal.z;
    yy += weight * normal.y * normal.y;
    yz += weight * normal.y * normal.z;
    zz += weight * normal.z * normal.z;
    b = b + weight * offset * normal;
    c += weight * offset * offset;
  }

  /// Adds `weight` times the squared distance to `point`. A share of it keeps the minimum unique.
  void add_point(Point point, double weight) {
    xx += weight;
    yy += weight;
    zz += weight;
    b = b + weight * point;
    c += weight * dot(point, point);
  }

  /// Counts everything so far `weight` times.
  void scale(double weight) {
    for (double* const part : {&xx, &xy, &xz, &yy, &yz, &zz, &c}) *part *= weight;
    b = weight * b;
  }

  friend Quadric operator+(const Quadric& p, const Quadric& q) {
    return {p.xx + q.xx, p.xy + q.xy, p.xz + q.xz, p.yy + q.yy,
            p.yz + q.yz, p.zz + q.zz, p.b + q.b,   p.c + q.c};
  }

  double at(Point p) const {
    return p.x * (xx * p.x + 2 * (xy * p.y + xz * p.z)) + p.y * (yy * p.y + 2 * yz * p.z) +
           zz * p.z * p.z - 2 * dot(b, p) + c;
  }

  /// The point of the smallest value; `otherwise` if A is singular, to the precision of doubles.
  Point minimum(Point otherwise) const {
    const double m00 = yy * zz - yz * yz, m01 = xz * yz - xy * zz, m02 = xy * yz - xz * yy;
    const double determinant = xx * m00 + xy * m01 + xz * m02;
    const double trace = xx + yy + zz;
    if (!(determinant > 1e-14 * trace * trace * trace)) return otherwise;
    const double m11 = xx * zz - xz * xz, m12 = xy * xz - xx * yz, m22 = xx * yy - xy * xy;
    const double scale = 1 / determinant;
    return {scale * (m00 * b.x + m01 * b.y + m02 * b.z),
            scale * (m01 * b.x + m11 * b.y + m12 * b.z),
            scale * (m02 * b.x + m12 * b.y + m22 * b.z)};
  }
};

PLAIT_END_NAMESPACE
