// examples/loop_both_ways.cpp: the same source refines a mesh in memory and a mesh in a store on
// disk.
//
// A program for semi-regular meshes visits the base triangles ("patches") and reads and writes the
// vertices of their grids with patch.at(level, i, j). If the program is written for any
// plait::PatchMesh, the same source runs
//   - over InCoreMesh: plain arrays, for meshes that fit into memory;
//   - over StorePatches: a store on disk, of which only a window is in memory, under a budget.
// This example does both with two algorithms: Loop subdivision (from the library) and a recursive
// computation of the surface area (from this program). Both give the same bits in memory and on
// disk.
//
//   loop_both_ways [MESH.ply [LEVELS]]        default: an octahedron, to level 5
#include <unistd.h>

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <string>

#include "plait/extend/in_core_mesh.h"
#include "plait/extend/patch.h"
#include "plait/extend/rule_patches.h"
#include "plait/layout.h"
#include "plait/mesh_io.h"
#include "plait/registry.h"
#include "plait/store.h"
#include "plait/store_info.h"
#include "plait/subdivide.h"

namespace {

using plait::BaseMesh;
using plait::FaceId;
using Position = plait::Vector3<float>;

// 1. A program's own algorithm. A patch at some level is a triangular grid with corners (0, 0),
//    (size, 0) and (0, size). `size` steps from the corner (i, j) span a smaller triangle: upright
//    for size > 0, upside down for size < 0. The code below does not depend on where vertices are
//    stored.
template <class Patch>
double area(const Patch& patch, int level, std::int64_t i, std::int64_t j, std::int64_t size) {
  if (size == 1 || size == -1) {
    const Position a = patch.at(level, i, j);
    const Position b = patch.at(level, i + size, j);
    const Position c = patch.at(level, i, j + size);
    const Position normal = plait::cross(b - a, c - a);
    return 0.5 * std::sqrt(double(plait::dot(normal, normal)));
  }
  const std::int64_t half = size / 2;
  return area(patch, level, i, j, half) +                // the three at the corners,
         area(patch, level, i + half, j, half) +         //
         area(patch, level, i, j + half, half) +         //
         area(patch, level, i + half, j + half, -half);  // and the one between them
}

template <class Patch>
double area_of(const Patch& patch, int level) {
  return area(patch, level, 0, 0, patch.size(level));
}

template <plait::PatchMesh Mesh>
double surface_area(Mesh& mesh, int level) {
  mesh.activate(level, 1, 0);  // levels 1 to `level` to read, none to write
  double sum = 0;
  for (FaceId face = 0; face < mesh.topology().faces.size(); ++face)
    sum += area_of(mesh.patch(face), level);
  return sum;
}

// 2. The library's Loop subdivision is written in the same way: plait/extend/rule_patches.h.
template <plait::PatchMesh Mesh>
void refine(Mesh& mesh, int level) {
  plait::refine_patches(mesh, level, plait::loop_scheme().rule<float>());
}

// 3. Whether two meshes hold the same bits at every vertex of every patch.
template <plait::PatchMesh First, plait::PatchMesh Second>
std::uint64_t count_differences(First& first, Second& second, int level) {
  first.activate(level, 1, 0);
  second.activate(level, 1, 0);
  std::uint64_t differences = 0;
  for (FaceId face = 0; face < first.topology().faces.size(); ++face) {
    const auto here = first.patch(face);
    const auto there = second.patch(face);
    const std::int64_t size = here.size(level);
    for (std::int64_t j = 0; j <= size; ++j)
      for (std::int64_t i = 0; i + j <= size; ++i)
        differences += !(here.at(level, i, j) == there.at(level, i, j));
  }
  return differences;
}

BaseMesh octahedron() {
  plait::IndexedMesh mesh;
  mesh.positions = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  mesh.faces = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4},
                {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  return BaseMesh::build(mesh);
}

bool run(const BaseMesh& base, int levels, const std::filesystem::path& path) {
  // In memory: plain arrays.
  plait::InCoreMesh<Position> arrays(base, levels);
  for (std::size_t vertex = 0; vertex < base.vertex_count(); ++vertex) {
    const plait::Vector3<double>& from = base.positions()[vertex];
    arrays.base_records()[vertex] = {float(from.x), float(from.y), float(from.z)};
  }
  for (int level = 1; level <= levels; ++level) refine(arrays, level);
  const double area_in_core = surface_area(arrays, levels);

  // On disk: a store. The budget limits the memory of its blocks.
  plait::StoreOptions options;
  options.backend = "pread";
  options.block_bytes = 64 << 10;
  options.budget_bytes = 16 << 20;
  options.durability = plait::Durability::kNone;  // a scratch store, which a power cut may destroy
  plait::Store store = plait::Store::create(path, base, options, plait::default_backends());
  plait::add_base_positions(store);
  const plait::AttributeId position = store.attribute("position");
  plait::StorePatches<Position> patches(store, position, options.budget_bytes / 2);
  for (int level = 1; level <= levels; ++level) {
    store.add_level(position);
    refine(patches, level);
  }
  const double area_in_store = surface_area(patches, levels);

  const std::uint64_t differences = count_differences(arrays, patches, levels);
  const plait::PagingStatistics paging = store.info().paging;
  std::printf("%llu base faces at level %d: %llu vertices\n",
              static_cast<unsigned long long>(base.face_count()), levels,
              static_cast<unsigned long long>(plait::counts_at_level(base, levels).vertices));
  std::printf("area over plain arrays  %.17g\n", area_in_core);
  std::printf("area over the store     %.17g  (%.1f MiB in memory at most, %llu blocks read)\n",
              area_in_store, double(paging.peak_frame_bytes) / (1 << 20),
              static_cast<unsigned long long>(paging.blocks_read));
  const bool agree = differences == 0 && area_in_core == area_in_store;
  if (agree)
    std::puts("both have the same bits");
  else
    std::printf("they differ at %llu vertices\n", static_cast<unsigned long long>(differences));
  return agree;
  // This program does not commit the store, so its destructor removes it. store.commit() would keep
  // it.
}

}  // namespace

int main(int count, char** arguments) {
  try {
    const BaseMesh mesh = count > 1 ? plait::read_base_mesh(arguments[1]) : octahedron();
    const int levels = count > 2 ? std::atoi(arguments[2]) : 5;
    // Faces that are close in space should be close on disk too.
    const BaseMesh base = plait::lay_out(mesh, plait::LayoutKind::kAutomatic).mesh;
    const std::filesystem::path path = std::filesystem::temp_directory_path() /
                                       ("loop_both_ways-" + std::to_string(::getpid()) + ".plait");
    return run(base, levels, path) ? 0 : 1;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "loop_both_ways: %s\n", error.what());
    return 1;
  }
}
