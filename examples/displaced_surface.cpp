// examples/displaced_surface.cpp: a coarse mesh is subdivided, and its fine vertices are moved
// along their normals by a procedural texture.
//
//   displaced_surface STORE [MESH.ply [LEVEL]]       without a mesh: a tetrahedron, to level 7
//   plait render STORE picture.png
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "plait/create_store.h"
#include "plait/mesh_io.h"
#include "plait/reader.h"
#include "plait/subdivide.h"
#include "plait/visit_vertices.h"

using plait::VertexRun;
using Point = plait::Vector3<float>;

// The texture: six octaves of ridges, from -1 to 1.
float texture(Point at) {
  float height = 0, weight = 0.5f;
  for (int octave = 0; octave < 6; ++octave, weight /= 2) {
    const float waves = std::sin(at.x + std::sin(at.y)) + std::sin(at.y + std::sin(at.z)) +
                        std::sin(at.z + std::sin(at.x));
    height += weight * (1 - 2 * std::abs(waves) / 3);
    at = 1.9f * Point{at.y, at.z, at.x} + Point{1, 2, 3};
  }
  return height;
}

void displace(plait::Store& store, float amplitude, float frequency) {
  plait::visit_vertices(
      store, {.name = "displace", .threads = 2},
      std::tuple{plait::reads<Point>("normal"), plait::updates<Point>("position")},
      [=](const VertexRun& run, std::span<const Point> normal, std::span<Point> position) {
        for (std::size_t i = 0; i < run.count; ++i)
          position[i] = position[i] + amplitude * texture(frequency * position[i]) * normal[i];
      });
  // The normals of the displaced surface, from the triangles around each vertex.
  plait::visit_vertices(
      store, {.name = "normals", .threads = 2},
      std::tuple{plait::rings_of<Point>("position"), plait::overwrites<Point>("normal")},
      [](const VertexRun& run, const plait::VertexRings<Point>& ring, std::span<Point> normal) {
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

// Counts the triangles of all patches, and those whose corners have a normal to the other side.
bool normals_fit(const plait::Store& store, int level) {
  const plait::Reader reader(store);
  const auto triangles = reader.patch_indices(level);
  std::size_t count = 0, wrong = 0;
  for (plait::FaceId face = 0; face < store.base().face_count(); ++face) {
    const plait::PatchView patch = reader.read_patch(face, level);
    std::vector<Point> position(plait::patch_vertex_count(patch.size())), normal = position;
    patch.attribute<Point>("position").copy_to(position);
    patch.attribute<Point>("normal").copy_to(normal);
    for (const auto& [a, b, c] : triangles) {
      const Point across = cross(position[b] - position[a], position[c] - position[a]);
      for (const auto corner : {a, b, c}) wrong += !(dot(across, normal[corner]) > 0);
      ++count;
    }
  }
  std::printf("%zu triangles, %zu normals to the wrong side\n", count, wrong);
  return wrong == 0;
}

int main(int count, char** words) try {
  if (count < 2) return std::fprintf(stderr, "usage: displaced_surface STORE [MESH [LEVEL]]\n"), 2;
  const plait::BaseMesh tetrahedron =
      plait::BaseMesh::build({.positions = {{1, 1, 1}, {-1, -1, 1}, {-1, 1, -1}, {1, -1, -1}},
                              .faces = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}});
  const plait::BaseMesh mesh = count > 2 ? plait::read_base_mesh(words[2]) : tetrahedron;
  const int level = count > 3 ? std::atoi(words[3]) : 7;
  plait::Store store = plait::create_store(words[1], mesh);
  plait::subdivide(store, {.levels = level, .normals = true});
  double size = 0;
  for (const auto& p : mesh.positions())
    size = std::max({size, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
  displace(store, float(size / 16), float(16 / size));
  store.commit();
  return normals_fit(store, level) ? 0 : 1;
} catch (const std::exception& error) {
  return std::fprintf(stderr, "displaced_surface: %s\n", error.what()), 1;
}
