#include "support/naive_subdivision.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>
#include <utility>

namespace plait::naive {
namespace {

/// On a border, triangle[1] and opposite[1] are kNone.
struct Edge {
  Index low = kNone, high = kNone;
  std::array<Index, 2> triangle{kNone, kNone};
  std::array<Index, 2> opposite{kNone, kNone};
  bool is_border() const { return triangle[1] == kNone; }
};

struct Edges {
  std::vector<Edge> list;                         ///< ascending by (low, high)
  std::vector<std::array<Index, 3>> of_triangle;  ///< [triangle][x] the edge opposite corner x

  Index find(Index a, Index b) const {
    const auto ends = std::minmax(a, b);
    const auto at = std::lower_bound(list.begin(), list.end(), ends,
                                     [](const Edge& edge, std::pair<Index, Index> key) {
                                       return std::pair(edge.low, edge.high) < key;
                                     });
    return static_cast<Index>(at - list.begin());
  }
};

[[noreturn]] void refuse(const std::string& what, Index a, Index b) {
  throw std::invalid_argument("naive mesh: " + what + " at edge " + std::to_string(a) + "-" +
                              std::to_string(b));
}

Edges find_edges(const Mesh& mesh) {
  struct HalfEdge {
    Index low, high, triangle, corner;
  };
  std::vector<HalfEdge> half_edges;
  half_edges.reserve(3 * mesh.triangles.size());
  for (Index t = 0; t < mesh.triangles.size(); ++t) {
    for (Index corner = 0; corner < 3; ++corner) {
      const Index from = mesh.triangles[t][(corner + 1) % 3];
      const Index to = mesh.triangles[t][(corner + 2) % 3];
      if (from >= mesh.points.size() || to >= mesh.points.size())
        refuse("index out of range", from, to);
      if (from == to) refuse("degenerate triangle", from, to);
      half_edges.push_back({std::min(from, to), std::max(from, to), t, corner});
    }
  }
  const auto key = [](const HalfEdge& half) {
    return std::uint64_t{half.low} << 32 | std::uint64_t{half.high};
  };
  std::sort(half_edges.begin(), half_edges.end(), [&](const HalfEdge& a, const HalfEdge& b) {
    return key(a) != key(b) ? key(a) < key(b) : a.triangle < b.triangle;
  });

  Edges edges;
  edges.list.reserve(half_edges.size() / 2);
  edges.of_triangle.resize(mesh.triangles.size());
  const auto runs_upward = [&](const HalfEdge& half) {
    return mesh.triangles[half.triangle][(half.corner + 1) % 3] == half.low;
  };
  for (std::size_t begin = 0, end; begin < half_edges.size(); begin = end) {
    end = begin + 1;
    while (end < half_edges.size() && key(half_edges[end]) == key(half_edges[begin])) ++end;
    Edge edge{half_edges[begin].low, half_edges[begin].high};
    if (end - begin > 2) refuse("more than two triangles", edge.low, edge.high);
    if (end - begin == 2 && runs_upward(half_edges[begin]) == runs_upward(half_edges[begin + 1]))
      refuse("orientations disagree", edge.low, edge.high);
    for (std::size_t k = begin; k < end; ++k) {
      const HalfEdge& half = half_edges[k];
      edge.triangle[k - begin] = half.triangle;
      edge.opposite[k - begin] = mesh.triangles[half.triangle][half.corner];
      edges.of_triangle[half.triangle][half.corner] = static_cast<Index>(edges.list.size());
    }
    edges.list.push_back(edge);
  }
  return edges;
}

/// The mesh with every triangle divided into four. `points` are the old vertices, then one vertex
/// per edge.
Mesh split(const Mesh& mesh, const Edges& edges, std::vector<Point> points) {
  Mesh fine;
  fine.points = std::move(points);
  fine.level = mesh.level + 1;
  fine.triangles.reserve(4 * mesh.triangles.size());
  const Index first_odd = static_cast<Index>(mesh.points.size());
  for (Index t = 0; t < mesh.triangles.size(); ++t) {
    const auto [a, b, c] = mesh.triangles[t];
    const Index bc = first_odd + edges.of_triangle[t][0];
    const Index ca = first_odd + edges.of_triangle[t][1];
    const Index ab = first_odd + edges.of_triangle[t][2];
    fine.triangles.push_back({a, ab, ca});
    fine.triangles.push_back({ab, b, bc});
    fine.triangles.push_back({ca, bc, c});
    fine.triangles.push_back({bc, ca, ab});  // the middle one, rotated by half a turn
  }
  return fine;
}

/// Number of neighbours of every vertex, and its neighbours along the border.
struct Valences {
  std::vector<Index> count;
  std::vector<std::array<Index, 2>> along_border;
  bool on_border(Index vertex) const { return along_border[vertex][0] != kNone; }
  bool is_irregular(Index vertex) const { return !on_border(vertex) && count[vertex] != 6; }
};

Valences find_valences(const Mesh& mesh, const Edges& edges) {
  Valences valences{std::vector<Index>(mesh.points.size(), 0),
                    std::vector<std::array<Index, 2>>(mesh.points.size(), {kNone, kNone})};
  for (const Edge& edge : edges.list) {
    for (const Index vertex : {edge.low, edge.high}) {
      const Index neighbour = vertex == edge.low ? edge.high : edge.low;
      ++valences.count[vertex];
      if (!edge.is_border()) continue;
      auto& along = valences.along_border[vertex];
      if (along[1] != kNone) refuse("vertex on two borders", vertex, neighbour);
      along[along[0] == kNone ? 0 : 1] = neighbour;
    }
  }
  for (Index v = 0; v < mesh.points.size(); ++v)
    if (valences.count[v] == 0) refuse("vertex without triangles", v, v);
  return valences;
}

/// Zorin's weights of the ring of an interior vertex of valence n != 6, beginning at the edge's
/// other end.
std::vector<double> butterfly_weights(std::size_t n) {
  if (n < 3) throw std::invalid_argument("naive butterfly: interior vertex of valence below 3");
  if (n == 3) return {5.0 / 12, -1.0 / 12, -1.0 / 12};
  if (n == 4) return {3.0 / 8, 0, -1.0 / 8, 0};
  std::vector<double> weights(n);
  for (std::size_t j = 0; j < n; ++j) {
    const double angle = 2 * std::numbers::pi * static_cast<double>(j) / static_cast<double>(n);
    weights[j] = (0.25 + std::cos(angle) + 0.5 * std::cos(2 * angle)) / static_cast<double>(n);
  }
  return weights;
}

/// The point across the side of `triangle` opposite its corner x.
Point wing(const Mesh& mesh, const Edges& edges, Index triangle, std::size_t x) {
  const Edge& outer = edges.list[edges.of_triangle[triangle][x]];
  const Triangle& inside = mesh.triangles[triangle];
  if (outer.is_border()) {
    return mesh.points[inside[(x + 1) % 3]] + mesh.points[inside[(x + 2) % 3]] -
           mesh.points[inside[x]];
  }
  return mesh.points[outer.opposite[outer.triangle[0] == triangle ? 1 : 0]];
}

}  // namespace

double loop_beta(std::size_t valence) {
  const double n = static_cast<double>(valence);
  const double root = 3.0 / 8 + std::cos(2 * std::numbers::pi / n) / 4;
  return (5.0 / 8 - root * root) / n;
}

Mesh subdivide_loop(const Mesh& mesh) {
  const Edges edges = find_edges(mesh);
  const Valences valences = find_valences(mesh, edges);
  const std::size_t vertex_count = mesh.points.size();

  std::vector<Point> points(vertex_count);
  points.reserve(vertex_count + edges.list.size());
  for (const Edge& edge : edges.list) {  // sums over the old neighbours that affect each vertex
    if (edge.is_border() || !valences.on_border(edge.low))
      points[edge.low] += mesh.points[edge.high];
    if (edge.is_border() || !valences.on_border(edge.high))
      points[edge.high] += mesh.points[edge.low];
  }
  for (Index v = 0; v < vertex_count; ++v) {
    const double n = valences.count[v];
    const double beta = valences.on_border(v) ? 1.0 / 8 : loop_beta(valences.count[v]);
    const double own = valences.on_border(v) ? 3.0 / 4 : 1 - n * beta;
    points[v] = own * mesh.points[v] + beta * points[v];
  }
  for (const Edge& edge : edges.list) {
    const Point ends = mesh.points[edge.low] + mesh.points[edge.high];
    points.push_back(edge.is_border() ? 0.5 * ends
                                      : 3.0 / 8 * ends + 1.0 / 8 *
                                                             (mesh.points[edge.opposite[0]] +
                                                              mesh.points[edge.opposite[1]]));
  }
  return split(mesh, edges, std::move(points));
}

Mesh subdivide_butterfly(const Mesh& mesh) {
  const Edges edges = find_edges(mesh);
  const Valences valences = find_valences(mesh, edges);
  const Index vertex_count = static_cast<Index>(mesh.points.size());

  std::vector<Point> points = mesh.points;
  points.resize(mesh.points.size() + edges.list.size());
  for (Index e = 0; e < edges.list.size(); ++e) {
    const Edge& edge = edges.list[e];
    Point& odd = points[vertex_count + e];
    const Point ends = mesh.points[edge.low] + mesh.points[edge.high];
    if (edge.is_border()) {
      const auto& before = valences.along_border[edge.low];
      const auto& after = valences.along_border[edge.high];
      odd = 9.0 / 16 * ends - 1.0 / 16 *
                                  (mesh.points[before[0] == edge.high ? before[1] : before[0]] +
                                   mesh.points[after[0] == edge.low ? after[1] : after[0]]);
    } else if (!valences.is_irregular(edge.low) && !valences.is_irregular(edge.high)) {
      odd = 0.5 * ends;
      for (std::size_t k = 0; k < 2; ++k) {
        const Index triangle = edge.triangle[k];
        odd += 1.0 / 8 * mesh.points[edge.opposite[k]];
        for (std::size_t x = 0; x < 3; ++x)
          if (edges.of_triangle[triangle][x] != e)
            odd += -1.0 / 16 * wing(mesh, edges, triangle, x);
      }
    }
  }

  const Rings rings(mesh);
  Ring ring;
  for (Index v = 0; v < vertex_count; ++v) {
    if (!valences.is_irregular(v)) continue;
    rings.find(v, ring);
    const std::size_t n = ring.neighbours.size();
    const std::vector<double> weights = butterfly_weights(n);
    for (std::size_t spoke = 0; spoke < n; ++spoke) {
      Point odd = 3.0 / 4 * mesh.points[v];
      for (std::size_t j = 0; j < n; ++j)
        odd += weights[j] * mesh.points[ring.neighbours[(spoke + j) % n]];
      const Index other = ring.neighbours[spoke];
      const double share = valences.is_irregular(other) ? 0.5 : 1;
      points[vertex_count + edges.find(v, other)] += share * odd;
    }
  }
  return split(mesh, edges, std::move(points));
}

Mesh subdivide_midpoint(const Mesh& mesh) {
  const Edges edges = find_edges(mesh);
  std::vector<Point> points = mesh.points;
  points.reserve(points.size() + edges.list.size());
  for (const Edge& edge : edges.list)
    points.push_back(0.5 * (mesh.points[edge.low] + mesh.points[edge.high]));
  return split(mesh, edges, std::move(points));
}

Mesh subdivide(Mesh mesh, Scheme scheme, int levels) {
  for (int level = 0; level < levels; ++level) {
    mesh = scheme == Scheme::kLoop        ? subdivide_loop(mesh)
           : scheme == Scheme::kButterfly ? subdivide_butterfly(mesh)
                                          : subdivide_midpoint(mesh);
  }
  return mesh;
}

Index vertex_at(const Mesh& mesh, Index input_triangle, std::int64_t i, std::int64_t j) {
  std::size_t triangle = input_triangle;
  for (int level = mesh.level; level > 0; --level) {
    const std::int64_t half = std::int64_t{1} << (level - 1);
    triangle *= 4;
    if (i >= half) {
      triangle += 1;
      i -= half;
    } else if (j >= half) {
      triangle += 2;
      j -= half;
    } else if (i + j > half) {
      triangle += 3;
      i = half - i;
      j = half - j;
    }
  }
  return mesh.triangles[triangle][i > 0 ? 1 : j > 0 ? 2 : 0];
}

std::vector<Index> patch_vertices(const Mesh& mesh, Index input_triangle) {
  const std::int64_t size = std::int64_t{1} << mesh.level;
  std::vector<Index> vertices;
  vertices.reserve(static_cast<std::size_t>((size + 1) * (size + 2) / 2));
  for (std::int64_t j = 0; j <= size; ++j)
    for (std::int64_t i = 0; i <= size - j; ++i)
      vertices.push_back(vertex_at(mesh, input_triangle, i, j));
  return vertices;
}

}  // namespace plait::naive
