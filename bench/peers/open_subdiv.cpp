// OpenSubdiv: uniform refinement of primvars, and stencil tables. Both need the topology of every
// level first. A program whose topology does not change computes it once, so for primvars there are
// two times: with the topology and without.
#include <opensubdiv/far/primvarRefiner.h>
#include <opensubdiv/far/stencilTable.h>
#include <opensubdiv/far/stencilTableFactory.h>
#include <opensubdiv/far/topologyDescriptor.h>
#include <opensubdiv/version.h>

#include <memory>

#include "micro/support.h"
#include "peers/peer.h"

namespace plait::bench {
namespace {

namespace Far = OpenSubdiv::Far;
namespace Sdc = OpenSubdiv::Sdc;
using Refiner = std::unique_ptr<Far::TopologyRefiner>;

struct Point {
  float x = 0, y = 0, z = 0;
  // NOLINTBEGIN(readability-identifier-naming): OpenSubdiv's names
  void Clear() { x = y = z = 0; }
  void AddWithWeight(const Point& other, float weight) {
    x += weight * other.x;
    y += weight * other.y;
    z += weight * other.z;
  }
  // NOLINTEND(readability-identifier-naming)
};

std::vector<Point> base_points(const BaseMesh& base) {
  std::vector<Point> points;
  for (const Vector3<double>& at : base.positions())
    points.push_back(
        {static_cast<float>(at.x), static_cast<float>(at.y), static_cast<float>(at.z)});
  return points;
}

/// The faces in the form that OpenSubdiv reads.
struct Faces {
  std::vector<int> counts, corners;
  explicit Faces(const BaseMesh& base) : counts(base.face_count(), 3) {
    for (const auto& face : base.faces())
      for (const VertexId corner : face) corners.push_back(static_cast<int>(corner));
  }
};

Refiner refine_topology(const BaseMesh& base, const Faces& faces, int level) {
  Far::TopologyDescriptor descriptor;
  descriptor.numVertices = static_cast<int>(base.vertex_count());
  descriptor.numFaces = static_cast<int>(base.face_count());
  descriptor.numVertsPerFace = faces.counts.data();
  descriptor.vertIndicesPerFace = faces.corners.data();
  Sdc::Options options;
  options.SetVtxBoundaryInterpolation(Sdc::Options::VTX_BOUNDARY_EDGE_ONLY);
  using Factory = Far::TopologyRefinerFactory<Far::TopologyDescriptor>;
  Refiner refiner(Factory::Create(descriptor, Factory::Options(Sdc::SCHEME_LOOP, options)));
  refiner->RefineUniform(Far::TopologyRefiner::UniformOptions(level));
  return refiner;
}

void copy_out(const std::vector<Point>& from, Points* points) {
  if (points == nullptr) return;
  for (const Point& at : from) points->push_back({at.x, at.y, at.z});
}

double with_primvars(const BaseMesh& base, int level, Points* points, bool topology_too) {
  const Faces faces(base);
  Refiner refiner;
  const double topology = thread_seconds([&] { refiner = refine_topology(base, faces, level); });
  std::vector<Point> coarser = base_points(base);
  coarser.reserve(static_cast<std::size_t>(refiner->GetLevel(level - 1).GetNumVertices()));
  std::vector<Point> finer;
  finer.reserve(static_cast<std::size_t>(refiner->GetLevel(level).GetNumVertices()));
  const double result = thread_seconds([&] {
    const Far::PrimvarRefiner primvars(*refiner);
    for (int next = 1; next <= level; ++next) {
      finer.resize(static_cast<std::size_t>(refiner->GetLevel(next).GetNumVertices()));
      Point* to = finer.data();
      primvars.Interpolate(next, coarser.data(), to);
      coarser.swap(finer);
    }
  });
  copy_out(coarser, points);
  return result + (topology_too ? topology : 0);
}

double with_stencils(const BaseMesh& base, int level, Points* points) {
  Far::StencilTableFactory::Options options;
  options.generateIntermediateLevels = false;
  options.generateOffsets = true;
  options.maxLevel = static_cast<unsigned>(level) & 0xfu;
  const std::unique_ptr<const Far::StencilTable> table(
      Far::StencilTableFactory::Create(*refine_topology(base, Faces(base), level), options));
  const std::vector<Point> from = base_points(base);
  std::vector<Point> to(static_cast<std::size_t>(table->GetNumStencils()));
  const double result = thread_seconds([&] {
    Point* first = to.data();
    table->UpdateValues(from.data(), first);
  });
  copy_out(to, points);
  return result;
}

}  // namespace

std::vector<Peer> open_subdiv_peers() {
  const std::string name = "OpenSubdiv " + std::to_string(OPENSUBDIV_VERSION_NUMBER / 10000) + "." +
                           std::to_string(OPENSUBDIV_VERSION_NUMBER / 100 % 100);
  const auto primvars = [](bool topology_too) {
    return [=](const BaseMesh& base, int level, Points* points) {
      return with_primvars(base, level, points, topology_too);
    };
  };
  return {{name, "primvar refinement, topology made before", primvars(false)},
          {name, "primvar refinement and topology", primvars(true)},
          {name, "stencils applied, tables made before", with_stencils}};
}

}  // namespace plait::bench
