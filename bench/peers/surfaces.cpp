#include "peers/surfaces.h"

#include <tuple>
#include <utility>

#include "plait/extend/pass.h"
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

Store make_surface(const Settings& settings, const LaidOutMesh& mesh, const std::string& name,
                   bool normals) {
  StoreOptions options;
  options.backend = "memory";
  options.block_bytes = settings.block_bytes();
  options.budget_bytes = 256 << 20;
  Store store = Store::create({}, mesh, options, default_backends());
  add_base_positions(store);
  subdivide(store,
            {.executor = ExecutorKind::kFused, .levels = settings.level, .normals = normals});
  if (name.starts_with("noise"))
    run_pass(store, {.name = "noise", .amplitude = 3e-7, .remakes_normals = normals});
  if (name == "fractal")
    run_pass(store, {.name = "fractal", .amplitude = 0.005, .remakes_normals = normals});
  if (name == "noise, other normals") make_other_normals(store);
  return store;
}

RawSurface::RawSurface(Store& store)
    : surroundings{store.base().topology(), 0, {}, store.base().positions()} {
  const Reader reader(store);
  for (const char* name : {"position", "normal"}) {
    const AttributeId id = store.attribute(name);
    AttributeLevels attribute{static_cast<std::uint32_t>(levels.size()),
                              store.attributes()[id].schema,
                              std::as_const(store).base_bytes(id),
                              {}};
    std::vector<Points>& records = levels.emplace_back();
    for (int level = 1; level <= store.finest_level(); ++level) {
      attribute.levels.push_back(
          &StoreAccess::level_file(std::as_const(store), id, level).geometry);
      add_level(reader, name, level, records.emplace_back());
    }
    surroundings.attributes.push_back(std::move(attribute));
  }
}

std::span<const std::byte> RawSurface::bytes_of(const ContextBlock& block) const {
  const auto at = static_cast<std::size_t>(block.level - 1);
  const LevelGeometry& geometry = *surroundings.attributes[block.attribute].levels[at];
  return std::as_bytes(std::span(levels[block.attribute][at]))
      .subspan(geometry.block_offset(block.block), geometry.block_bytes(block.block));
}

}  // namespace plait::bench
