#include "remesh/sampled_surface.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <span>
#include <string>
#include <tuple>

#include "base/threads.h"
#include "distance/closest_point.h"
#include "export/patch_selection.h"
#include "mesh/parallel_parts.h"
#include "plait/detail/drawn_triangles.h"
#include "plait/error.h"
#include "plait/patch_writer.h"
#include "plait/reader.h"
#include "plait/visit_vertices.h"
#include "write_patches.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

Vector3<float> in_float32(const Point& p) {
  return {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)};
}

/// Writes the records record_of(value) of all vertices, whose values are in the order of
/// SampleNumbers.
template <class Record, class Value, class RecordOf = std::identity>
void write_attribute(Store& store, const std::string& name, int levels, int threads,
                     const std::vector<Value>& values, const ProgressCallback& progress,
                     RecordOf record_of = {}) {
  store.add_attribute(schema_of<Record>(name), levels);
  const SampleNumbers numbers(store.base(), levels);
  visit_vertices(
      store, {.name = "remesh", .threads = threads, .progress = progress},
      std::tuple{overwrites<Record>(name)}, [&](const VertexRun& run, std::span<Record> to) {
        const auto first =
            values.begin() + static_cast<std::ptrdiff_t>(numbers.first_of(run.level) + run.first);
        std::transform(first, first + static_cast<std::ptrdiff_t>(run.count), to.begin(),
                       record_of);
      });
}

/// The progress of one of `count` works of the same size.
ProgressCallback nth_of(const ProgressCallback& progress, std::uint64_t number,
                        std::uint64_t count) {
  if (!progress) return {};
  return [&progress, number, count](const Progress& now) {
    return progress({now.phase, number * now.total + now.done, count * now.total});
  };
}

std::vector<ClosestPoint> closest_of_vertices(const Surface& scan, const TriangleTree& tree) {
  std::vector<ClosestPoint> closest(scan.positions.size());
  for_parts(closest.size(), [&](std::size_t first, std::size_t last, std::size_t) {
    FaceId hint = 0;
    for (std::size_t vertex = first; vertex < last; ++vertex) {
      closest[vertex] = tree.closest(scan.positions[vertex], hint);
      hint = closest[vertex].face;
    }
  });
  return closest;
}

/// The number of faces that a thread writes between two calls of the progress callback.
constexpr FaceId kFacesAtOnce = 64;

}  // namespace

void write_levels(const SampledSurface& surface, ComponentType precision, Store& store, int threads,
                  const ProgressCallback& progress) {
  const std::uint64_t count = surface.distances.empty() ? 2 : 3;
  if (precision == ComponentType::kFloat64)
    write_attribute<Point>(store, "position", surface.levels, threads, surface.positions,
                           nth_of(progress, 0, count));
  else
    write_attribute<Vector3<float>>(store, "position", surface.levels, threads, surface.positions,
                                    nth_of(progress, 0, count), in_float32);
  write_attribute<std::uint8_t>(store, "turned", surface.levels, threads, surface.turned,
                                nth_of(progress, 1, count));
  if (!surface.distances.empty())
    write_attribute<float>(store, "distance", surface.levels, threads, surface.distances,
                           nth_of(progress, 2, count));
}

void write_attributes(const ScanAttributes& attributes, const Surface& scan,
                      std::span<const SurfacePoint> samples, const SampledSurface& surface,
                      Store& store, const AttributeWriting& options) {
  const SampleNumbers numbers(store.base(), surface.levels);
  const std::size_t faces = store.base().face_count();
  for (std::size_t attribute = 0; attribute < attributes.count(); ++attribute) {
    const AttributeSchema& schema = attributes.schema(attribute);
    const std::size_t bytes = schema.record_bytes();
    store.add_attribute(schema, surface.levels);
    const auto fill = [&](PatchWriter& writer, FaceId first, FaceId after) {
      std::vector<std::byte> records(patch_vertex_count(numbers.size()) * bytes);
      for (FaceId face = first; face < after; ++face) {
        std::byte* to = records.data();
        for (std::int64_t j = 0; j <= numbers.size(); ++j)
          for (std::int64_t i = 0; i + j <= numbers.size(); ++i, to += bytes)
            attributes.record_at(attribute, scan, samples[numbers.of(face, i, j)], to);
        writer.write_patch_of_bytes(schema.name, face, surface.levels, records);
      }
    };
    const auto report = [&](FaceId done) {
      if (options.progress &&
          !options.progress({"attributes", attribute * faces + done, attributes.count() * faces}))
        throw Error(ErrorCode::kCancelled, "remesh: cancelled, attributes");
    };
    write_patches(store, {.job = "remesh",
                          .writer = {.attributes = {schema.name}},
                          .threads = options.threads,
                          .faces_at_once = kFacesAtOnce,
                          .scratch_bytes = patch_vertex_count(numbers.size()) * bytes,
                          .begins = options.begins,
                          .fill = fill,
                          .report = report});
  }
}

IndexedMesh small_triangles(const SampledSurface& surface) {
  IndexedMesh mesh;
  const SampleNumbers numbers(surface.base, surface.levels);
  mesh.positions = surface.positions;
  mesh.faces.reserve(surface.base.face_count() << (2 * surface.levels));
  for (FaceId face = 0; face < surface.base.face_count(); ++face)
    numbers.for_each_triangle(face, [&](std::uint64_t a, std::uint64_t b, std::uint64_t c) {
      mesh.faces.push_back(
          {static_cast<VertexId>(a), static_cast<VertexId>(b), static_cast<VertexId>(c)});
    });
  return mesh;
}

IndexedMesh drawn_triangles(const SampledSurface& surface, const BaseMesh& deep) {
  IndexedMesh mesh;
  const SampleNumbers numbers(surface.base, surface.levels);
  const PatchSelection patches(deep, surface.levels, all_faces(deep));
  mesh.positions = surface.positions;
  mesh.faces.reserve(patches.triangle_count());
  for (FaceId face = 0; face < deep.face_count(); ++face) {
    const DrawnDepths drawn = patches.drawn(face);
    const int finer = surface.levels - drawn.grid();
    const auto number = [&](FacePoint at) {
      return static_cast<VertexId>(numbers.of(face, at.i << finer, at.j << finer));
    };
    for_each_drawn_triangle(
        drawn,
        [&](FacePoint a, FacePoint b, FacePoint c) {
          mesh.faces.push_back({number(a), number(b), number(c)});
        },
        [] {});
  }
  return mesh;
}

double farthest_vertex(const Surface& scan, const TriangleTree& tree) {
  double most = 0;
  for (const ClosestPoint& point : closest_of_vertices(scan, tree))
    most = std::max(most, point.squared_distance);
  return std::sqrt(most);
}

std::vector<float> distances_at_samples(const Surface& scan, const IndexedMesh& small,
                                        const TriangleTree& tree) {
  const std::vector<ClosestPoint> closest = closest_of_vertices(scan, tree);
  std::vector<float> distances(small.positions.size(), 0);
  for (const ClosestPoint& point : closest)
    for (const VertexId sample : small.faces[point.face])
      distances[sample] =
          std::max(distances[sample], static_cast<float>(std::sqrt(point.squared_distance)));
  return distances;
}

PLAIT_END_NAMESPACE
