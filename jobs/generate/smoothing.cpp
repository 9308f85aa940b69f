#include "generate/smoothing.h"

#include <cstddef>
#include <cstdint>

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace generation {
namespace {

/// [vertex] 1 on a border, else 0.
std::vector<std::uint32_t> find_border(const IndexedMesh& mesh) {
  // The sides opposite an inner vertex form a cycle, so the sum of their start indices equals the
  // sum of their end indices. The sides opposite a border vertex form a path between two vertices,
  // so the sums differ.
  std::vector<std::uint64_t> difference(mesh.positions.size(), 0);
  for (const auto& [a, b, c] : mesh.faces) {
    difference[a] += std::uint64_t{c} - b;
    difference[b] += std::uint64_t{a} - c;
    difference[c] += std::uint64_t{b} - a;
  }
  std::vector<std::uint32_t> border(difference.size());
  for (std::size_t vertex = 0; vertex < border.size(); ++vertex)
    border[vertex] = difference[vertex] != 0 ? 1 : 0;
  return border;
}

struct Neighbourhoods {
  std::vector<std::uint32_t> border, valence;

  explicit Neighbourhoods(const IndexedMesh& mesh)
      : border(find_border(mesh)), valence(mesh.positions.size(), 0) {
    for (const auto& face : mesh.faces)
      for (const VertexId vertex : face) ++valence[vertex];
  }
};

void smooth_step(IndexedMesh& mesh, const Neighbourhoods& around, double weight,
                 std::vector<Vector3<double>>& sum) {
  sum.assign(mesh.positions.size(), {0, 0, 0});
  // The two faces of an inner edge run along it in opposite directions, so each neighbour is
  // counted once.
  for (const auto& [a, b, c] : mesh.faces) {
    sum[a] = sum[a] + mesh.positions[b];
    sum[b] = sum[b] + mesh.positions[c];
    sum[c] = sum[c] + mesh.positions[a];
  }
  for (std::size_t vertex = 0; vertex < sum.size(); ++vertex) {
    if (around.border[vertex] != 0) continue;
    Vector3<double>& position = mesh.positions[vertex];
    position = position + weight * (1.0 / around.valence[vertex] * sum[vertex] - position);
  }
}

}  // namespace

void smooth(IndexedMesh& mesh, double weight) {
  std::vector<Vector3<double>> sum;
  smooth_step(mesh, Neighbourhoods(mesh), weight, sum);
}

void taubin_smooth(IndexedMesh& mesh, int steps) {
  constexpr double kShrink = 0.5, kSwell = -0.53;
  const Neighbourhoods around(mesh);
  std::vector<Vector3<double>> sum;
  for (int step = 0; step < steps; ++step) {
    smooth_step(mesh, around, kShrink, sum);
    smooth_step(mesh, around, kSwell, sum);
  }
}

}  // namespace generation
PLAIT_END_NAMESPACE
