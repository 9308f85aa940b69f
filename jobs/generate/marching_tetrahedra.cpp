#include "generate/marching_tetrahedra.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>
#include <vector>

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace generation {
namespace {

/// The corners of a cube are numbered by the bits of their offset: x = 1, y = 2, z = 4. The corners
/// of each tetrahedron go from 0 to 7 and add one axis at a time. So the bits of an edge's first
/// corner are among those of its second one, and the first corner together with the added axes
/// identifies the edge.
struct Tetrahedron {
  std::array<std::uint32_t, 4> corners;
  bool is_positive;  ///< the corners form a right-handed frame
};
constexpr std::array<Tetrahedron, 6> kTetrahedra{{{{0, 1, 3, 7}, true},
                                                  {{0, 2, 6, 7}, true},
                                                  {{0, 4, 5, 7}, true},
                                                  {{0, 2, 3, 7}, false},
                                                  {{0, 1, 5, 7}, false},
                                                  {{0, 4, 6, 7}, false}}};

/// [bit set of one or two corners] an even permutation that puts these corners first.
constexpr std::array<std::array<std::uint8_t, 4>, 16> kFrontFirst{{{},
                                                                   {0, 1, 2, 3},
                                                                   {1, 0, 3, 2},
                                                                   {0, 1, 2, 3},
                                                                   {2, 0, 1, 3},
                                                                   {0, 2, 3, 1},
                                                                   {1, 2, 0, 3},
                                                                   {},
                                                                   {3, 0, 2, 1},
                                                                   {0, 3, 1, 2},
                                                                   {1, 3, 2, 0},
                                                                   {},
                                                                   {2, 3, 0, 1},
                                                                   {},
                                                                   {},
                                                                   {}}};

class Marcher {
 public:
  Marcher(const Grid& grid, float level)
      : grid_(grid), level_(level), layer_size_(grid.width * grid.height) {
    for (std::size_t i = 0; i < 2; ++i) {
      values_[i].resize(layer_size_);
      vertex_on_edge_[i].resize(8 * layer_size_);
    }
  }

  IndexedMesh run(const FieldLayer& field, const Progress& progress) && {
    field(0, values_[0]);
    clear_edges(0);
    for (std::size_t z = 0; z + 1 < grid_.depth; ++z) {
      field(z + 1, values_[(z + 1) % 2]);
      clear_edges((z + 1) % 2);
      for (std::size_t y = 0; y + 1 < grid_.height; ++y)
        for (std::size_t x = 0; x + 1 < grid_.width; ++x) march_cube(x, y, z);
      progress(static_cast<double>(z + 1) / static_cast<double>(grid_.depth - 1));
    }
    return std::move(mesh_);
  }

 private:
  void clear_edges(std::size_t layer) {
    std::fill(vertex_on_edge_[layer].begin(), vertex_on_edge_[layer].end(), kNoId);
  }

  float value(std::size_t x, std::size_t y, std::size_t z) const {
    return values_[z % 2][y * grid_.width + x];
  }

  void march_cube(std::size_t x, std::size_t y, std::size_t z) {
    std::uint32_t inside_cube = 0;
    for (std::uint32_t corner = 0; corner < 8; ++corner)
      if (value(x + (corner & 1), y + (corner >> 1 & 1), z + (corner >> 2)) > level_)
        inside_cube |= 1u << corner;
    if (inside_cube == 0 || inside_cube == 0xff) return;
    for (const Tetrahedron& tetrahedron : kTetrahedra) {
      std::uint32_t inside = 0;
      for (std::uint32_t i = 0; i < 4; ++i)
        inside |= (inside_cube >> tetrahedron.corners[i] & 1u) << i;
      if (inside == 0 || inside == 0xf) continue;
      march_tetrahedron({x, y, z}, tetrahedron, inside);
    }
  }

  void march_tetrahedron(const std::array<std::size_t, 3>& cube, const Tetrahedron& tetrahedron,
                         std::uint32_t inside) {
    // Three corners inside are the same as one outside, with the orientation reversed.
    const bool three = __builtin_popcount(inside) == 3;
    const auto& front = kFrontFirst[three ? 0xf & ~inside : inside];
    const auto vertex = [&](std::size_t from, std::size_t to) {
      return edge_vertex(cube, tetrahedron.corners[front[from]], tetrahedron.corners[front[to]]);
    };
    const bool outward = tetrahedron.is_positive != three;
    if (__builtin_popcount(inside) == 2) {
      const VertexId a = vertex(0, 2), b = vertex(0, 3), c = vertex(1, 3), d = vertex(1, 2);
      add_face(a, b, c, outward);
      add_face(a, c, d, outward);
    } else {
      add_face(vertex(0, 1), vertex(0, 2), vertex(0, 3), outward);
    }
  }

  void add_face(VertexId a, VertexId b, VertexId c, bool outward) {
    if (outward)
      mesh_.faces.push_back({a, b, c});
    else
      mesh_.faces.push_back({a, c, b});
  }

  /// The vertex on the edge between two corners of a cube. The first call for an edge makes it.
  VertexId edge_vertex(const std::array<std::size_t, 3>& cube, std::uint32_t first,
                       std::uint32_t second) {
    const auto [low, high] = std::minmax(first, second);
    const auto at = [&cube](std::uint32_t corner) {
      return std::array{cube[0] + (corner & 1), cube[1] + (corner >> 1 & 1),
                        cube[2] + (corner >> 2)};
    };
    const auto [x, y, z] = at(low);
    VertexId& vertex = vertex_on_edge_[z % 2][8 * (y * grid_.width + x) + (low ^ high)];
    if (vertex != kNoId) return vertex;
    const auto [end_x, end_y, end_z] = at(high);
    const double start_value = value(x, y, z), end_value = value(end_x, end_y, end_z);
    // A vertex keeps a distance from the grid points, because many edges meet there and their
    // vertices would coincide.
    const double t = std::clamp((level_ - start_value) / (end_value - start_value), 0.05, 0.95);
    const auto place = [t](std::size_t from, std::size_t to) {
      return static_cast<double>(from) + (to > from ? t : 0);
    };
    mesh_.positions.push_back(grid_.origin + grid_.spacing * Vector3<double>{place(x, end_x),
                                                                             place(y, end_y),
                                                                             place(z, end_z)});
    vertex = static_cast<VertexId>(mesh_.positions.size() - 1);
    return vertex;
  }

  Grid grid_;
  float level_;
  std::size_t layer_size_;
  std::array<std::vector<float>, 2> values_;             ///< [z modulo 2][y][x]
  std::array<std::vector<VertexId>, 2> vertex_on_edge_;  ///< [z modulo 2][y][x][axes added]
  IndexedMesh mesh_;
};

}  // namespace

IndexedMesh march_tetrahedra(const Grid& grid, float level, const FieldLayer& field,
                             const Progress& progress) {
  return Marcher(grid, level).run(field, progress);
}

}  // namespace generation
PLAIT_END_NAMESPACE
