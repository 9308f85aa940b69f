#include "remesh/base_numbers.h"

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "sample/samples.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

BaseMesh in_face_order(const BaseMesh& base) {
  IndexedMesh mesh;
  std::vector<VertexId> numbers(base.vertex_count(), kNoId);
  for (auto corners : base.faces()) {
    for (VertexId& corner : corners) {
      if (numbers[corner] == kNoId) {
        numbers[corner] = static_cast<VertexId>(mesh.positions.size());
        mesh.positions.push_back(base.positions()[corner]);
      }
      corner = numbers[corner];
    }
    mesh.faces.push_back(corners);
  }
  return BaseMesh::build(std::move(mesh), "base mesh");
}

}  // namespace

void number_in_face_order(BaseSamples& samples) {
  SampledSurface& surface = samples.surface;
  BaseMesh base = in_face_order(surface.base);
  const SampleNumbers before(surface.base, surface.levels), now(base, surface.levels);
  std::vector<SurfacePoint> points(samples.samples.size());
  std::vector<std::uint8_t> turned(surface.turned.size());
  for (FaceId face = 0; face < base.face_count(); ++face)
    for (std::int64_t j = 0; j <= now.size(); ++j)
      for (std::int64_t i = 0; i + j <= now.size(); ++i) {
        const std::uint64_t from = before.of(face, i, j), to = now.of(face, i, j);
        points[to] = samples.samples[from];
        turned[to] = surface.turned[from];
      }
  samples.samples = std::move(points);
  surface.turned = std::move(turned);
  surface.base = std::move(base);
}

void give_base_positions(SampledSurface& surface) {
  const std::span<const std::array<VertexId, 3>> faces = surface.base.faces();
  const auto end = static_cast<std::ptrdiff_t>(surface.base.vertex_count());
  surface.base = BaseMesh::build(
      {{surface.positions.begin(), surface.positions.begin() + end}, {faces.begin(), faces.end()}},
      "base mesh");
}

PLAIT_END_NAMESPACE
