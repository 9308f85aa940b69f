#include "peers/compression_surfaces.h"

#include <algorithm>
#include <tuple>
#include <utility>

#include "displace/displace.h"
#include "paging/level_cursor.h"
#include "plait/extend/edge_index.h"
#include "plait/extend/store_access.h"
#include "plait/registry.h"
#include "plait/subdivide.h"
#include "plait/visit_vertices.h"

namespace plait::bench {
namespace {

using Point = Vector3<float>;

/// Normals as many programs make them: the sum of the cross products of the triangles around.
void make_other_normals(Store& store) {
  visit_vertices(store, {.name = "other normals"},
                 std::tuple{rings_of<Point>("position"), overwrites<Point>("normal")},
                 [](const VertexRun& run, const VertexRings<Point>& ring, std::span<Point> normal) {
                   const int n = ring.valence(), triangles = ring.is_border() ? n - 1 : n;
                   for (std::size_t i = 0; i < run.count; ++i) {
                     Point sum{};
                     for (int k = 0; k < triangles; ++k)
                       sum = sum + cross(ring.neighbour(i, k) - ring.vertex(i),
                                         ring.neighbour(i, (k + 1) % n) - ring.vertex(i));
                     normal[i] = normalized(sum);
                   }
                 });
}

}  // namespace

Store make_surface(const SurfaceSettings& settings, const LaidOutMesh& mesh,
                   const std::string& name, bool normals) {
  StoreOptions options;
  options.backend = "memory";
  options.block_bytes = static_cast<std::uint64_t>(settings.block_kib) << 10;
  options.budget_bytes = 256 << 20;
  Store store = Store::create({}, mesh, options, default_backends());
  add_base_positions(store);
  subdivide(store,
            {.executor = ExecutorKind::kFused, .levels = settings.level, .normals = normals});
  if (name.starts_with("noise"))
    displace(store, {.kind = DisplacementKind::kNoise, .amplitude = 3e-7});
  if (name == "fractal") displace(store, {.kind = DisplacementKind::kFractal, .amplitude = 0.005});
  if (name == "noise, other normals") make_other_normals(store);
  return store;
}

std::span<const std::byte> MeasuredSurface::bytes_of(const ContextBlock& block) const {
  const auto at = static_cast<std::size_t>(block.level - 1);
  const LevelGeometry& geometry = *surroundings.attributes[block.attribute].levels[at];
  return std::span(levels[block.attribute][at])
      .subspan(geometry.block_offset(block.block), geometry.block_bytes(block.block));
}

MeasuredAttribute read_attribute(const SurfaceSettings& settings, Store& store,
                                 const std::string& name, MeasuredSurface& surface) {
  const AttributeId id = store.attribute(name);
  const auto number = static_cast<std::uint32_t>(surface.levels.size());
  MeasuredAttribute attribute{&surface,       number,  store.attributes()[id].schema,
                              settings.level, nullptr, {}};
  AttributeLevels levels{number, attribute.schema, std::as_const(store).base_bytes(id), {}};
  surface.levels.emplace_back();
  for (int level = 1; level <= settings.level; ++level) {
    LevelFile& file = StoreAccess::level_file(store, id, level);
    LevelCursor cursor(StoreAccess::open_session(store), file);
    std::vector<std::byte>& bytes = surface.levels.back().emplace_back();
    for (EdgeId edge = 0; edge < store.base().edge_count(); ++edge) {
      const auto slot = cursor.slot(edge).bytes;
      bytes.insert(bytes.end(), slot.begin(), slot.end());
    }
    levels.levels.push_back(&file.geometry);
    attribute.finest = &file.geometry;
  }
  surface.surroundings.attributes.push_back(levels);
  // The same distance between the measured blocks.
  const std::uint64_t count = attribute.finest->block_count();
  const auto wanted = std::min<std::uint64_t>(count, static_cast<std::uint64_t>(settings.blocks));
  for (std::uint64_t i = 0; i < wanted; ++i) attribute.blocks.push_back(i * count / wanted);
  return attribute;
}

}  // namespace plait::bench
