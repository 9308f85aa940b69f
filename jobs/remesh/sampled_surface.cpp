#include "remesh/sampled_surface.h"

#include <algorithm>
#include <span>
#include <string>
#include <tuple>

#include "plait/visit_vertices.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// Writes the records of all vertices, which are in the order of SampleNumbers.
template <class Record>
void write_attribute(Store& store, const std::string& name, int levels, int threads,
                     const std::vector<Record>& records, const ProgressCallback& progress) {
  store.add_attribute(schema_of<Record>(name), levels);
  const SampleNumbers numbers(store.base(), levels);
  visit_vertices(
      store, {.name = "remesh", .threads = threads, .progress = progress},
      std::tuple{overwrites<Record>(name)}, [&](const VertexRun& run, std::span<Record> to) {
        const auto first =
            records.begin() + static_cast<std::ptrdiff_t>(numbers.first_of(run.level) + run.first);
        std::copy_n(first, run.count, to.begin());
      });
}

}  // namespace

void write_levels(const SampledSurface& surface, Store& store, int threads,
                  const ProgressCallback& progress) {
  write_attribute(store, "position", surface.levels, threads, surface.positions, progress);
  if (!surface.turned.empty())
    write_attribute(store, "turned", surface.levels, threads, surface.turned, progress);
}

IndexedMesh small_triangles(const SampledSurface& surface) {
  IndexedMesh mesh;
  const SampleNumbers numbers(surface.base, surface.levels);
  mesh.positions.reserve(surface.positions.size());
  for (const Vector3<float>& p : surface.positions)
    mesh.positions.push_back({double{p.x}, double{p.y}, double{p.z}});
  mesh.faces.reserve(surface.base.face_count() << (2 * surface.levels));
  for (FaceId face = 0; face < surface.base.face_count(); ++face)
    numbers.for_each_triangle(face, [&](std::uint64_t a, std::uint64_t b, std::uint64_t c) {
      mesh.faces.push_back(
          {static_cast<VertexId>(a), static_cast<VertexId>(b), static_cast<VertexId>(c)});
    });
  return mesh;
}

PLAIT_END_NAMESPACE
