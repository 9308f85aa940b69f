// support/naive_limit.h: limit positions and normals of Loop surfaces in double, computed with
// masks on naive rings, and normals computed without any mask. It is a part of the oracle and
// shares no code with the library.
//
// Interior masks: C. Loop, "Smooth subdivision surfaces based on triangles", 1987; H. Hoppe et al.,
// "Piecewise smooth surface reconstruction", 1994, appendix. Border masks: derived below.
//
// Border vertex v with ring p_1 .. p_k, counterclockwise from border to border. One Loop step is
//   v'   = 3/4 v + 1/8 (p_1 + p_k)
//   p_1' = 1/2 v + 1/2 p_1                                       (p_k' alike)
//   p_i' = 3/8 v + 3/8 p_i + 1/8 (p_{i-1} + p_{i+1})             1 < i < k
// A left eigenvector (c; y_1 = a, y_2, .., y_{k-1}, y_k = a) of this matrix, eigenvalue lambda, is
// read off its columns. p_1' uses no p_2, so the columns of p_2 .. p_{k-1} are a discrete sine
// equation that vanishes at 1 and k:
//   y_i = sin((i-1) theta), theta = pi/(k-1), lambda = 3/8 + cos(theta)/4,
// and the columns of p_1 and v are
//   a (lambda - 1/2) = (y_2 + c)/8,    c (lambda - 3/4) = a + 3/8 sum(y).
// Eliminating a gives c (lambda-1)(lambda-1/4) = 3/8 (lambda-1/2) sum(y) + y_2/8, without a special
// case at k = 4, where lambda = 1/2 and the weights are Hoppe's (-2; -1, 2, 2, -1). For k = 2 there
// is no y and lambda = 1/4: (-2; 1, 1). The other tangent is p_1 - p_k, eigenvalue 1/2.
//
// From k = 8 on, a second eigenvalue, 3/8 + cos(2 theta)/4, exceeds 1/2. Then this border rule is
// not tangent-plane continuous, and the mask gives the plane of the two triangles at the border.
#pragma once

#include <vector>

#include "support/naive_subdivision.h"

namespace plait::naive {

/// The positions of the vertices after infinitely many Loop steps.
std::vector<Point> loop_limit_points(const Mesh& mesh);

/// Unit normals of the Loop surface at the limit points, outward for counterclockwise triangles;
/// zero where the tangents are parallel.
std::vector<Point> loop_limit_normals(const Mesh& mesh);

/// Unit normals from the triangles at each vertex, weighted by area, without any mask. On a mesh
/// refined often enough they can check loop_limit_normals(), and they are correct for any scheme.
std::vector<Point> area_weighted_normals(const Mesh& mesh);

double dot(Point a, Point b);
Point cross(Point a, Point b);
double length(Point a);
/// `a` divided by its length; the zero vector stays zero.
Point unit(Point a);
/// The angle between two vectors, in radians; accurate near zero and near pi.
double angle_between(Point a, Point b);

/// The weights (c; a, y_2, .., y_{k-1}, a) above for a border vertex of k neighbours, c first.
/// REQUIRES: k >= 2.
std::vector<double> border_tangent_weights(std::size_t k);

}  // namespace plait::naive
