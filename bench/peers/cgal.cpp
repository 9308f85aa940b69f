// CGAL: Loop_subdivision on a Surface_mesh. It refines the connectivity level by level.
#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/subdivision_method_3.h>
#include <CGAL/version.h>

#include "micro/support.h"
#include "peers/peer.h"

namespace plait::bench {
namespace {

double refine(const BaseMesh& base, int level, Points* points) {
  using Point = CGAL::Simple_cartesian<double>::Point_3;
  CGAL::Surface_mesh<Point> mesh;
  using Vertex = CGAL::Surface_mesh<Point>::Vertex_index;
  mesh.reserve(static_cast<std::uint32_t>(base.vertex_count()),
               static_cast<std::uint32_t>(base.edge_count()),
               static_cast<std::uint32_t>(base.face_count()));
  for (const Vector3<double>& at : base.positions()) mesh.add_vertex(Point(at.x, at.y, at.z));
  for (const auto& [a, b, c] : base.faces()) mesh.add_face(Vertex(a), Vertex(b), Vertex(c));

  const double result = thread_seconds([&] {
    CGAL::Subdivision_method_3::Loop_subdivision(
        mesh, CGAL::parameters::number_of_iterations(static_cast<unsigned>(level)));
  });
  if (points != nullptr)
    for (const Vertex vertex : mesh.vertices()) {
      const Point& at = mesh.point(vertex);
      points->push_back(
          {static_cast<float>(at.x()), static_cast<float>(at.y()), static_cast<float>(at.z())});
    }
  return result;
}

}  // namespace

std::vector<Peer> cgal_peers() {
  return {{"CGAL " CGAL_VERSION_STR, "Loop_subdivision, float64 points", refine}};
}

}  // namespace plait::bench
