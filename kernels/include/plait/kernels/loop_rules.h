// plait/kernels/loop_rules.h: Loop subdivision in place, a vertex at a time, for loops of one's
// own.
//
// C. Loop, "Smooth Subdivision Surfaces Based on Triangles", master's thesis, University of Utah,
// 1987; the in-place form of the even rule, from the new odd neighbours, is I. Guskov's,
// "Non-replicating indexing for out-of-core processing of semi-regular triangular surface meshes",
// section 5. Limit masks: D. Zorin, P. Schroeder, "Subdivision for Modeling and Animation",
// SIGGRAPH course notes, 2000. Pinned by tests/kernels/loop_test.cpp against an independent oracle.
//
// These are functions of the library and not inline, so that every program gets the library's bits,
// whatever flags it is compiled with (a compiler that may contract a multiplication and an addition
// into one rounding gives others). Pinned by tests/outside. `Real` is float or double. Safe from
// any number of threads; no function fails.
#pragma once

#include "plait/vector3.h"

namespace plait::loop {

/// Odd vertex between `a` and `b`, opposite `c` and `d`: 3/8 (a + b) + 1/8 (c + d). The same bits
/// with `a` and `b`, or `c` and `d`, exchanged.
template <class Real>
[[gnu::noinline]] Vector3<Real> odd_vertex(const Vector3<Real>& a, const Vector3<Real>& b,
                                           const Vector3<Real>& c, const Vector3<Real>& d) noexcept;

/// Odd vertex on a border, between `a` and `b`: their middle.
template <class Real>
[[gnu::noinline]] Vector3<Real> odd_border_vertex(const Vector3<Real>& a,
                                                  const Vector3<Real>& b) noexcept;

/// Even vertex of valence 6 from its new odd neighbours p0 .. p5 in order around it:
/// 2/5 v + 1/10 (p0 + ... + p5). The same bits wherever the order starts and whichever way it runs.
template <class Real>
[[gnu::noinline]] Vector3<Real> even_vertex(const Vector3<Real>& v, const Vector3<Real>& p0,
                                            const Vector3<Real>& p1, const Vector3<Real>& p2,
                                            const Vector3<Real>& p3, const Vector3<Real>& p4,
                                            const Vector3<Real>& p5) noexcept;

/// Even vertex on a border, from its two new neighbours along it: 1/2 v + 1/4 (p + q).
template <class Real>
[[gnu::noinline]] Vector3<Real> even_border_vertex(const Vector3<Real>& v, const Vector3<Real>& p,
                                                   const Vector3<Real>& q) noexcept;

/// Limit position of a vertex of valence 6, its neighbours as for even_vertex:
/// 1/2 v + 1/12 (p0 + ... + p5).
template <class Real>
[[gnu::noinline]] Vector3<Real> limit_vertex(const Vector3<Real>& v, const Vector3<Real>& p0,
                                             const Vector3<Real>& p1, const Vector3<Real>& p2,
                                             const Vector3<Real>& p3, const Vector3<Real>& p4,
                                             const Vector3<Real>& p5) noexcept;

/// Limit position of a vertex on a border, from its two neighbours along it: 1/6 (4 v + p + q).
template <class Real>
[[gnu::noinline]] Vector3<Real> limit_border_vertex(const Vector3<Real>& v, const Vector3<Real>& p,
                                                    const Vector3<Real>& q) noexcept;

}  // namespace plait::loop
