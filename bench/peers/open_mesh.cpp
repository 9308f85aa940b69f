// OpenMesh: uniform Loop subdivision on a half-edge mesh. It splits the faces level by level.
#include <OpenMesh/Core/System/config.h>

#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <OpenMesh/Tools/Subdivider/Uniform/LoopT.hh>

#include "micro/support.h"
#include "peers/peer.h"

namespace plait::bench {
namespace {

double refine(const BaseMesh& base, int level, Points* points) {
  using Mesh = OpenMesh::TriMesh_ArrayKernelT<>;
  using Vertex = Mesh::VertexHandle;
  Mesh mesh;
  for (const Vector3<double>& at : base.positions())
    mesh.add_vertex(
        Mesh::Point(static_cast<float>(at.x), static_cast<float>(at.y), static_cast<float>(at.z)));
  for (const auto& [a, b, c] : base.faces())
    mesh.add_face(Vertex(static_cast<int>(a)), Vertex(static_cast<int>(b)),
                  Vertex(static_cast<int>(c)));

  OpenMesh::Subdivider::Uniform::LoopT<Mesh> subdivider;
  const double result = thread_seconds([&] { subdivider(mesh, static_cast<std::size_t>(level)); });
  if (points != nullptr)
    for (const Vertex vertex : mesh.vertices()) {
      const Mesh::Point& at = mesh.point(vertex);
      points->push_back({at[0], at[1], at[2]});
    }
  return result;
}

}  // namespace

std::vector<Peer> open_mesh_peers() {
  const int version = OM_VERSION;
  return {{"OpenMesh " + std::to_string(version >> 16) + "." + std::to_string(version >> 8 & 0xff),
           "Subdivider::Uniform::LoopT, float32 points", refine}};
}

}  // namespace plait::bench
