// examples/own_kernel.cpp: a kernel of your own on a store that is larger than its memory budget:
// Laplacian smoothing in which no vertex moves farther than its bound.
// A pass that reads neighbours writes to a second attribute, which then gets the name of the first.
// One run in memory and one on the disk, within a small budget, give the same bits.
//
//   own_kernel STORE       makes STORE, a directory, and leaves it there
#include <atomic>
#include <cmath>
#include <cstdio>
#include <string>

#include "plait/digest.h"
#include "plait/layout.h"
#include "plait/registry.h"
#include "plait/store_info.h"
#include "plait/subdivide.h"
#include "plait/visit_vertices.h"

using Point = plait::Vector3<float>;

struct Anchor {  // a record type of this program: where a vertex was, and how far it may move
  Point rest;
  float bound;
};
template <>
struct plait::RecordTraits<Anchor> : plait::RecordOf<float, 4> {};

void set_anchors(plait::Store& store) {
  store.add_attribute(plait::schema_of<Anchor>("anchor"),
                      store.finest_level());  // with all its levels
  plait::visit_vertices(
      store, {}, std::tuple{plait::reads<Point>("position"), plait::overwrites<Anchor>("anchor")},
      [](const plait::VertexRun& run, std::span<const Point> position, std::span<Anchor> anchor) {
        for (std::size_t i = 0; i < run.count; ++i)
          anchor[i] = {position[i], 0.01f * std::abs(position[i].z)};
      });
}

void smooth(plait::Store& store, int threads) {
  store.add_attribute(plait::schema_of<Point>("smoother"), store.finest_level());
  plait::visit_vertices(
      store, {.name = "smooth", .threads = threads},
      std::tuple{plait::rings_of<Point>("position"), plait::reads<Anchor>("anchor"),
                 plait::overwrites<Point>("smoother")},
      [](const plait::VertexRun& run, const plait::VertexRings<Point>& position,
         std::span<const Anchor> anchor, std::span<Point> smoother) {
        for (std::size_t i = 0; i < run.count; ++i) {
          Point sum{};
          for (int k = 0; k < position.valence(); ++k) sum = sum + position.neighbour(i, k);
          const Point move = 1 / float(position.valence()) * sum - anchor[i].rest;
          const float length = std::sqrt(dot(move, move)), bound = anchor[i].bound;
          smoother[i] = anchor[i].rest + (length > bound ? bound / length : 1) * move;
        }
      });
  store.replace_attribute(store.attribute("position"), store.attribute("smoother"));
}

// Counts the vertices beyond their bound, and those that have reached it.
bool keeps_bound(plait::Store& store) {
  std::atomic<int> beyond = 0, reached = 0;
  plait::visit_vertices(
      store, {}, std::tuple{plait::reads<Point>("position"), plait::reads<Anchor>("anchor")},
      [&](const plait::VertexRun& run, std::span<const Point> at, std::span<const Anchor> anchor) {
        for (std::size_t i = 0; i < run.count; ++i) {
          const Point move = at[i] - anchor[i].rest;
          beyond += std::sqrt(dot(move, move)) > anchor[i].bound + 1e-6f;
          reached += std::sqrt(dot(move, move)) > anchor[i].bound - 1e-6f;
        }
      });
  std::printf("%d vertices at their bound, %d beyond\n", reached - beyond, beyond.load());
  return beyond == 0 && reached > 0;
}

std::string run(const char* path, const plait::StoreOptions& options, int threads) {
  plait::IndexedMesh mesh;  // a tetrahedron
  mesh.positions = {{1, 1, 1}, {-1, -1, 1}, {-1, 1, -1}, {1, -1, -1}};
  mesh.faces = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  const auto base = plait::rebase(plait::BaseMesh::build(mesh), 4, plait::Scheme::kMidpoint);
  plait::Store store = plait::Store::create(path, plait::lay_out(base, plait::LayoutKind::kHilbert),
                                            options, plait::default_backends(),
                                            // Patches are the 1024 faces of level 4.
                                            {.base_level = 4});
  plait::add_base_positions(store);
  plait::subdivide(store, {.scheme = plait::Scheme::kMidpoint, .levels = 8});
  set_anchors(store);
  for (int pass = 0; pass < 10; ++pass) smooth(store, threads);
  std::printf("%s: %lu KiB, of which %lu KiB in memory\n", options.backend.c_str(),
              store.info().stored_bytes >> 10, store.info().paging.peak_frame_bytes >> 10);
  if (!store.path().empty()) store.commit();
  return keeps_bound(store) ? plait::digest(store).to_string() : "bound exceeded";
}

int main(int count, char** words) try {
  if (count != 2) return std::fprintf(stderr, "usage: own_kernel STORE\n"), 2;
  const std::string known = run("", {.backend = "memory"}, 1);
  const std::string found = run(words[1], {.block_bytes = 4096, .budget_bytes = 1 << 20}, 2);
  if (known != found || known.size() != 32) return std::puts("they differ, or are wrong"), 1;
  return std::puts("both have the same bits"), 0;
} catch (const std::exception& error) {
  return std::fprintf(stderr, "own_kernel: %s\n", error.what()), 1;
}
