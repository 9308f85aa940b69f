// CGAL: points of its generator, and its AABB tree. CGAL is GPL, so this is a program for
// measurements, and nothing of it is in what plait ships.
#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Random.h>
#include <CGAL/Simple_cartesian.h>
#include <CGAL/point_generators_3.h>

#include <cmath>
#include <cstdint>
#include <vector>

#include "peers/peer.h"

namespace plait::bench {
namespace {

using Kernel = CGAL::Simple_cartesian<double>;
using Triangle = Kernel::Triangle_3;
using Triangles = std::vector<Triangle>;
using Primitive = CGAL::AABB_triangle_primitive<Kernel, Triangles::const_iterator>;
using Tree = CGAL::AABB_tree<CGAL::AABB_traits<Kernel, Primitive>>;

/// Triangles without area have no points, and their edges are those of their neighbours.
Triangles triangles_of(const IndexedMesh& mesh) {
  const auto point = [&](VertexId vertex) {
    const Vector3<double>& p = mesh.positions[vertex];
    return Kernel::Point_3(p.x, p.y, p.z);
  };
  Triangles triangles;
  for (const auto& [a, b, c] : mesh.faces)
    if (const Triangle triangle(point(a), point(b), point(c)); !triangle.is_degenerate())
      triangles.push_back(triangle);
  return triangles;
}

}  // namespace

std::vector<double> cgal_distances(const IndexedMesh& from, const IndexedMesh& to,
                                   std::uint64_t samples) {
  const Triangles source = triangles_of(from), target = triangles_of(to);
  Tree tree(target.begin(), target.end());
  tree.accelerate_distance_queries();
  CGAL::Random random(5);
  CGAL::Random_points_in_triangles_3<Kernel::Point_3> points(source, random);
  std::vector<double> distances;
  for (std::uint64_t i = 0; i < samples; ++i)
    distances.push_back(std::sqrt(tree.squared_distance(*points++)));
  return distances;
}

}  // namespace plait::bench
