// examples/transparent_loop.cpp: Loop subdivision by a program's own loops over patches. The store
// decides which blocks are in memory. The result is compared with that of plait::subdivide().
//
// A patch is a grid with corners (0, 0), (n, 0) and (0, n). Points just beyond a side are in the
// next patch. The patch that owns a side computes the vertices on it. Base vertices are in many
// patches, and are computed from rings that the patches collect.
#include <cmath>
#include <cstdio>
#include <numbers>

#include "plait/extend/rule_patches.h"
#include "plait/reader.h"
#include "plait/registry.h"
#include "plait/subdivide.h"

using Point = plait::Vector3<double>;

// Calls visit(i, j, on_border, at) for what a patch computes; at(di, dj) is the vertex that far
// away.
template <class Patch, class Visit>
void for_each_own(const Patch& patch, int level, Visit visit) {
  const std::int64_t n = patch.size(level);
  for (std::int64_t j = 0; j <= n; ++j)
    for (std::int64_t i = 0; i + j <= n; ++i) {
      const int side = i + j == n ? 0 : i == 0 ? 1 : j == 0 ? 2 : -1;  // -1: inside the patch
      if (plait::is_corner(level, i, j) || (side >= 0 && !patch.owns(side))) continue;
      visit(i, j, side >= 0 && patch.is_border(side),
            [&](auto di, auto dj) -> Point& { return patch.at(level, i + di, j + dj); });
    }
}

void refine(plait::StorePatches<Point>& mesh, int level) {
  const plait::Topology base = mesh.topology();
  plait::RingTable<Point> rings(base.edges.size());
  mesh.activate(level, level, level);  // to read levels up to `level`, and to write only this one
  for (plait::FaceId face = 0; face < base.faces.size(); ++face) {
    const auto patch = mesh.patch(face);
    for_each_own(patch, level, [&](auto i, auto j, bool on_border, auto at) {
      if (i % 2 == 0 && j % 2 == 0) return;  // not new
      // New vertices lie on the edges of the coarser grid, whose coordinates are even.
      const std::int64_t di = i % 2, dj = j % 2 == 0 ? 0 : 1 - 2 * di;  // to an end of the edge
      const std::int64_t oi = di + 2 * dj, oj = -2 * di - dj;           // to an opposite vertex
      const Point ends = at(-di, -dj) + at(di, dj);
      at(0, 0) = on_border ? 0.5 * ends : 0.375 * ends + 0.125 * (at(-oi, -oj) + at(oi, oj));
    });
    plait::collect_rings(patch, base, level, rings);
  }
  mesh.activate(level, 1, level - 1);
  for (plait::FaceId face = 0; level > 1 && face < base.faces.size(); ++face) {
    const auto patch = mesh.patch(face);
    for_each_own(patch, level, [&](auto i, auto j, bool on_border, auto at) {
      if (i % 2 != 0 || j % 2 != 0) return;                                        // not old
      const std::int64_t di = i == 0 ? 0 : 1, dj = j == 0 ? 0 : di == 0 ? 1 : -1;  // along a side
      at(0, 0) = on_border ? 0.5 * at(0, 0) + 0.25 * (at(di, dj) + at(-di, -dj))
                           : 0.4 * at(0, 0) + 0.1 * (at(1, 0) + at(0, 1) + at(-1, 1) + at(-1, 0) +
                                                     at(0, -1) + at(1, -1));
    });
  }
  for (plait::VertexId vertex = 0; vertex < mesh.base_records().size(); ++vertex) {
    Point& v = mesh.base_records()[vertex];
    const bool on_border = plait::is_border_vertex(base, vertex);
    Point sum{};  // of all new neighbours, or of the two on the border
    const int n = plait::for_each_spoke(base, vertex, [&](plait::EdgeId edge) {
      if (!on_border || base.edges[edge].is_border()) sum = sum + rings.next_to(base, edge, vertex);
    });
    const double centre = 0.375 + 0.25 * std::cos(2 * std::numbers::pi / n);
    const double weight = 1.6 / n * (0.625 - centre * centre);
    v = on_border ? 0.5 * v + 0.25 * sum : (1 - n * weight) * v + weight * sum;
  }
}

int main() {
  constexpr int kLevels = 5;
  const plait::BaseMesh cup = plait::BaseMesh::build(  // an octahedron without one face
      {.positions = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}},
       .faces = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}}});
  const plait::StoreOptions options{.backend = "memory"};
  plait::Store store = plait::Store::create({}, cup, options, plait::default_backends());
  plait::Store expected = plait::Store::create({}, cup, options, plait::default_backends());
  for (plait::Store* each : {&store, &expected})
    plait::add_base_positions(*each, plait::ComponentType::kFloat64);
  plait::subdivide(expected, {.levels = kLevels});

  for (int level = 1; level <= kLevels; ++level) {
    store.add_level(store.attribute("position"));
    plait::StorePatches<Point> mesh(store, store.attribute("position"), options.budget_bytes / 2);
    refine(mesh, level);
  }
  double farthest = 0;
  const plait::Reader made(store), known(expected);
  for (plait::FaceId face = 0; face < cup.face_count(); ++face) {
    std::vector<Point> here(plait::patch_vertex_count(1 << kLevels)), there = here;
    made.read_patch(face, kLevels).attribute<Point>("position").copy_to(here);
    known.read_patch(face, kLevels).attribute<Point>("position").copy_to(there);
    for (std::size_t i = 0; i < here.size(); ++i)
      farthest = std::fmax(farthest, std::sqrt(dot(here[i] - there[i], here[i] - there[i])));
  }
  std::printf("farthest from plait::subdivide(): %g\n", farthest);
  return farthest < 1e-14 ? 0 : 1;
}
