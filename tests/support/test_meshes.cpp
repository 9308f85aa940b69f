#include "support/test_meshes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <map>
#include <numbers>
#include <random>
#include <utility>

namespace plait::test {
namespace {

constexpr double kPi = std::numbers::pi;

/// All coordinates rounded to float32.
IndexedMesh rounded(IndexedMesh mesh) {
  for (auto& p : mesh.positions)
    for (int axis = 0; axis < 3; ++axis) p[axis] = static_cast<float>(p[axis]);
  return mesh;
}

std::uint32_t wrapped(std::uint32_t index, std::uint32_t period) {
  return period == 0 ? index : index % period;
}

/// Two triangles for each cell of a grid whose vertex (column, row) is column + row * stride. A
/// period closes the grid in that direction; 0 leaves it open.
void add_cells(IndexedMesh& mesh, std::uint32_t columns, std::uint32_t rows, std::uint32_t stride,
               std::uint32_t column_period, std::uint32_t row_period) {
  for (std::uint32_t row = 0; row < rows; ++row) {
    for (std::uint32_t column = 0; column < columns; ++column) {
      const auto at = [&](std::uint32_t right, std::uint32_t up) {
        return wrapped(column + right, column_period) + wrapped(row + up, row_period) * stride;
      };
      mesh.faces.push_back({at(0, 0), at(1, 0), at(1, 1)});
      mesh.faces.push_back({at(0, 0), at(1, 1), at(0, 1)});
    }
  }
}

class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}
  /// A number from 0 to count - 1, the same on every platform (the distributions of the standard
  /// library are not).
  std::uint32_t below(std::size_t count) { return static_cast<std::uint32_t>(engine_() % count); }
  double jitter() { return (below(2001) - 1000.0) / 1000.0; }
  template <class Value>
  void shuffle(std::vector<Value>& values) {
    for (std::size_t k = values.size(); k > 1; --k) std::swap(values[k - 1], values[below(k)]);
  }

 private:
  std::mt19937_64 engine_;
};

/// [from, to] -> the face in which the edge runs in this direction.
using HalfEdges = std::map<std::pair<VertexId, VertexId>, FaceId>;

VertexId opposite(const std::array<VertexId, 3>& face, VertexId from) {
  return face[0] == from ? face[2] : face[1] == from ? face[0] : face[1];
}

HalfEdges half_edges(const IndexedMesh& mesh) {
  HalfEdges halves;
  for (FaceId f = 0; f < mesh.faces.size(); ++f)
    for (std::size_t k = 0; k < 3; ++k) halves[{mesh.faces[f][k], mesh.faces[f][(k + 1) % 3]}] = f;
  return halves;
}

VertexId add_vertex(IndexedMesh& mesh, const Vector3<double>& position) {
  mesh.positions.push_back(position);
  return static_cast<VertexId>(mesh.positions.size() - 1);
}

/// One random flip, edge split or face split that keeps the mesh a simple manifold.
void edit(IndexedMesh& mesh, Random& random) {
  const HalfEdges halves = half_edges(mesh);
  const auto& [ends, left] = *std::next(halves.begin(), random.below(halves.size()));
  const auto [a, b] = ends;
  const auto beyond = halves.find({b, a});
  const VertexId c = opposite(mesh.faces[left], a);
  const Vector3<double> middle = 0.5 * (mesh.positions[a] + mesh.positions[b]);
  const std::uint32_t kind = random.below(4);
  if (kind == 0) {
    const VertexId m = add_vertex(mesh, 2.0 / 3 * middle + 1.0 / 3 * mesh.positions[c]);
    mesh.faces[left] = {a, b, m};
    mesh.faces.push_back({b, c, m});
    mesh.faces.push_back({c, a, m});
  } else if (kind == 1) {
    const VertexId m = add_vertex(mesh, middle);
    mesh.faces[left] = {a, m, c};
    mesh.faces.push_back({m, b, c});
    if (beyond == halves.end()) return;
    const VertexId d = opposite(mesh.faces[beyond->second], b);
    mesh.faces[beyond->second] = {b, m, d};
    mesh.faces.push_back({m, a, d});
  } else if (beyond != halves.end()) {
    const VertexId d = opposite(mesh.faces[beyond->second], b);
    if (c == d || halves.contains({c, d}) || halves.contains({d, c})) return;
    mesh.faces[left] = {a, d, c};
    mesh.faces[beyond->second] = {b, c, d};
  }
}

IndexedMesh randomised(IndexedMesh mesh, std::uint64_t seed, std::uint32_t edits, double noise) {
  Random random(seed);
  for (std::uint32_t k = 0; k < edits; ++k) edit(mesh, random);
  for (auto& p : mesh.positions)
    for (int axis = 0; axis < 3; ++axis) p[axis] += noise * random.jitter();

  std::vector<VertexId> renamed(mesh.positions.size());
  for (VertexId v = 0; v < renamed.size(); ++v) renamed[v] = v;
  random.shuffle(renamed);
  IndexedMesh shuffled;
  shuffled.positions.resize(renamed.size());
  for (VertexId v = 0; v < renamed.size(); ++v) shuffled.positions[renamed[v]] = mesh.positions[v];
  for (const auto& [a, b, c] : mesh.faces) {
    shuffled.faces.push_back({renamed[a], renamed[b], renamed[c]});
    std::rotate(shuffled.faces.back().begin(), shuffled.faces.back().begin() + random.below(3),
                shuffled.faces.back().end());
  }
  random.shuffle(shuffled.faces);
  return rounded(std::move(shuffled));
}

}  // namespace

IndexedMesh tetrahedron() {
  return {{{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}},
          {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {1, 3, 2}}};
}

IndexedMesh octahedron() {
  return {{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}},
          {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}}};
}

IndexedMesh icosahedron() {
  const double g = std::numbers::phi;
  return rounded(
      {{{-1, g, 0},
        {1, g, 0},
        {-1, -g, 0},
        {1, -g, 0},
        {0, -1, g},
        {0, 1, g},
        {0, -1, -g},
        {0, 1, -g},
        {g, 0, -1},
        {g, 0, 1},
        {-g, 0, -1},
        {-g, 0, 1}},
       {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
        {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
        {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}}});
}

IndexedMesh seven_vertex_torus() {
  IndexedMesh mesh;
  for (std::uint32_t v = 0; v < 7; ++v) {
    const double angle = 2 * kPi * v / 7;
    mesh.positions.push_back({std::cos(angle), std::sin(angle), std::cos(3 * angle)});
    mesh.faces.push_back({v, (v + 1) % 7, (v + 3) % 7});
    mesh.faces.push_back({v, (v + 3) % 7, (v + 2) % 7});
  }
  return rounded(std::move(mesh));
}

IndexedMesh torus_grid(std::uint32_t columns, std::uint32_t rows) {
  IndexedMesh mesh;
  for (std::uint32_t row = 0; row < rows; ++row) {
    for (std::uint32_t column = 0; column < columns; ++column) {
      const double around = 2 * kPi * column / columns, tube = 2 * kPi * row / rows;
      const double radius = 2 + std::cos(tube);
      mesh.positions.push_back(
          {radius * std::cos(around), radius * std::sin(around), std::sin(tube)});
    }
  }
  add_cells(mesh, columns, rows, columns, columns, rows);
  return rounded(std::move(mesh));
}

IndexedMesh bipyramid(std::uint32_t n) {
  IndexedMesh mesh{{{0.125, 0, 1}, {0, 0.125, -1.5}}, {}};
  for (std::uint32_t k = 0; k < n; ++k) {
    const double angle = 2 * kPi * k / n, radius = 1 + 0.2 * std::sin(3.0 * k);
    mesh.positions.push_back(
        {radius * std::cos(angle), radius * std::sin(angle), 0.1 * std::cos(5.0 * k)});
    mesh.faces.push_back({0, 2 + k, 2 + (k + 1) % n});
    mesh.faces.push_back({1, 2 + (k + 1) % n, 2 + k});
  }
  return rounded(std::move(mesh));
}

IndexedMesh two_faces_back_to_back() {
  IndexedMesh mesh = single_triangle();
  mesh.faces.push_back({0, 2, 1});
  return mesh;
}

IndexedMesh single_triangle() { return {{{0, 0, 0}, {2, 0, 0.5}, {0.5, 1.5, 0}}, {{0, 1, 2}}}; }

IndexedMesh two_triangles() {
  return {{{0, 0, 0}, {2, 0, 0.5}, {2, 2, 0}, {0, 2, 1}}, {{0, 1, 2}, {0, 2, 3}}};
}

IndexedMesh open_fan(std::uint32_t n) {
  IndexedMesh mesh{{{0, 0, 0.25}}, {}};
  for (std::uint32_t k = 0; k <= n; ++k) {
    const double step = std::min(kPi / 3, 1.25 * kPi / n);
    const double angle = step * k, radius = 1 + 0.2 * std::sin(3.0 * k);
    mesh.positions.push_back(
        {radius * std::cos(angle), radius * std::sin(angle), 0.1 * std::cos(5.0 * k)});
    if (k < n) mesh.faces.push_back({0, 1 + k, 2 + k});
  }
  return rounded(std::move(mesh));
}

IndexedMesh closed_fan(std::uint32_t n) {
  IndexedMesh mesh{{{0, 0.125, 0.5}}, {}};
  for (std::uint32_t k = 0; k < n; ++k) {
    const double angle = 2 * kPi * k / n, radius = 1 + 0.2 * std::sin(3.0 * k);
    mesh.positions.push_back(
        {radius * std::cos(angle), radius * std::sin(angle), 0.1 * std::cos(5.0 * k)});
    mesh.faces.push_back({0, 1 + k, 1 + (k + 1) % n});
  }
  return rounded(std::move(mesh));
}

IndexedMesh sheet(std::uint32_t columns, std::uint32_t rows) {
  IndexedMesh mesh;
  for (std::uint32_t row = 0; row <= rows; ++row)
    for (std::uint32_t column = 0; column <= columns; ++column)
      mesh.positions.push_back(
          {double(column), double(row), 0.4 * std::sin(1.1 * column) * std::cos(0.9 * row)});
  add_cells(mesh, columns, rows, columns + 1, 0, 0);
  return rounded(std::move(mesh));
}

IndexedMesh cube_grid(std::uint32_t n) {
  IndexedMesh mesh;
  std::map<std::array<std::uint32_t, 3>, VertexId> numbers;
  const auto vertex = [&](std::array<std::uint32_t, 3> at) {
    const auto [found, is_new] =
        numbers.try_emplace(at, static_cast<VertexId>(mesh.positions.size()));
    if (is_new) mesh.positions.push_back({double(at[0]), double(at[1]), double(at[2])});
    return found->second;
  };
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (const bool far : {false, true})
      for (std::uint32_t i = 0; i < n; ++i)
        for (std::uint32_t j = 0; j < n; ++j) {
          const auto at = [&](std::uint32_t u, std::uint32_t v) {
            std::array<std::uint32_t, 3> corner{};
            corner[axis] = far ? n : 0;
            corner[(axis + 1) % 3] = far ? i + u : i + v;
            corner[(axis + 2) % 3] = far ? j + v : j + u;
            return vertex(corner);
          };
          mesh.faces.push_back({at(0, 0), at(1, 0), at(1, 1)});
          mesh.faces.push_back({at(0, 0), at(1, 1), at(0, 1)});
        }
  return mesh;
}

IndexedMesh annulus(std::uint32_t n) {
  IndexedMesh mesh;
  for (const double radius : {2.0, 1.0}) {
    for (std::uint32_t column = 0; column < n; ++column) {
      const double angle = 2 * kPi * column / n;
      mesh.positions.push_back(
          {radius * std::cos(angle), radius * std::sin(angle), 0.2 * std::sin(2.0 * column)});
    }
  }
  add_cells(mesh, n, 1, n, n, 0);
  return rounded(std::move(mesh));
}

IndexedMesh two_components() {
  IndexedMesh mesh = tetrahedron();
  const IndexedMesh other = sheet(2, 1);
  const auto offset = static_cast<VertexId>(mesh.positions.size());
  for (const auto& p : other.positions) mesh.positions.push_back(p + Vector3<double>{4, 0, 0});
  for (const auto& [a, b, c] : other.faces)
    mesh.faces.push_back({a + offset, b + offset, c + offset});
  return mesh;
}

IndexedMesh random_sphere(std::uint64_t seed, std::uint32_t edits) {
  return randomised(octahedron(), seed, edits, 0.05);
}

IndexedMesh random_torus(std::uint64_t seed, std::uint32_t edits) {
  return randomised(torus_grid(5, 4), seed, edits, 0.05);
}

IndexedMesh random_sheet(std::uint64_t seed, std::uint32_t edits) {
  return randomised(sheet(3, 3), seed, edits, 0.05);
}

std::vector<NamedMesh> closed_meshes() {
  std::vector<NamedMesh> meshes{{"tetrahedron", tetrahedron()},
                                {"octahedron", octahedron()},
                                {"icosahedron", icosahedron()},
                                {"seven_vertex_torus", seven_vertex_torus()},
                                {"torus_grid 4x4", torus_grid(4, 4)}};
  for (const std::uint32_t n : {3u, 5u, 7u, 12u, 26u})
    meshes.push_back({"bipyramid " + std::to_string(n), bipyramid(n)});
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    meshes.push_back({"random_sphere " + std::to_string(seed), random_sphere(seed, 40)});
    meshes.push_back({"random_torus " + std::to_string(seed), random_torus(seed, 40)});
  }
  return meshes;
}

std::vector<NamedMesh> border_meshes() {
  std::vector<NamedMesh> meshes{{"single_triangle", single_triangle()},
                                {"two_triangles", two_triangles()},
                                {"sheet 3x2", sheet(3, 2)},
                                {"sheet 5x4", sheet(5, 4)},
                                {"annulus 5", annulus(5)},
                                {"two_components", two_components()}};
  for (const std::uint32_t n : {2u, 3u, 6u, 9u})
    meshes.push_back({"open_fan " + std::to_string(n), open_fan(n)});
  for (const std::uint32_t n : {3u, 4u, 6u, 8u})
    meshes.push_back({"closed_fan " + std::to_string(n), closed_fan(n)});
  for (const std::uint64_t seed : {1u, 2u, 3u})
    meshes.push_back({"random_sheet " + std::to_string(seed), random_sheet(seed, 60)});
  return meshes;
}

std::vector<NamedMesh> all_meshes() {
  std::vector<NamedMesh> meshes = closed_meshes();
  for (NamedMesh& mesh : border_meshes()) meshes.push_back(std::move(mesh));
  return meshes;
}

IndexedMesh side_by_side(const std::vector<IndexedMesh>& meshes) {
  IndexedMesh all;
  double end = 0;
  for (const IndexedMesh& mesh : meshes) {
    const auto first = static_cast<VertexId>(all.positions.size());
    double low = INFINITY, high = -INFINITY;
    for (const Vector3<double>& p : mesh.positions) {
      low = std::min(low, p.x);
      high = std::max(high, p.x);
    }
    for (const Vector3<double>& p : mesh.positions)
      all.positions.push_back(p + Vector3<double>{end - low, 0, 0});
    for (const auto& [a, b, c] : mesh.faces) all.faces.push_back({a + first, b + first, c + first});
    end += high - low + 1;
  }
  return rounded(std::move(all));
}

naive::Mesh to_naive(const IndexedMesh& mesh) {
  naive::Mesh result;
  for (const auto& p : mesh.positions) result.points.push_back({p.x, p.y, p.z});
  result.triangles.assign(mesh.faces.begin(), mesh.faces.end());
  return result;
}

}  // namespace plait::test
