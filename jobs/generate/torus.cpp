#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "generate/kinds.h"
#include "generate/portable_math.h"
#include "generate/random.h"
#include "generate/reduce.h"
#include "generate/smoothing.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace generation {
namespace {

constexpr double kLargeRadius = 1.0, kSmallRadius = 0.4;

/// A grid of `around` by `across` vertices. The seed shifts it by a fraction of a cell.
IndexedMesh torus_grid(std::uint64_t around, std::uint64_t across, std::uint64_t seed) {
  Random random(seed);
  const double shift = random.unit();
  IndexedMesh mesh;
  mesh.positions.reserve(around * across);
  mesh.faces.reserve(2 * around * across);
  for (std::uint64_t i = 0; i < around; ++i) {
    const SineCosine large =
        portable_sine_cosine((static_cast<double>(i) + shift) / static_cast<double>(around));
    for (std::uint64_t j = 0; j < across; ++j) {
      const SineCosine small =
          portable_sine_cosine((static_cast<double>(j) + shift) / static_cast<double>(across));
      const double radius = kLargeRadius + kSmallRadius * small.cosine;
      mesh.positions.push_back(
          {radius * large.cosine, radius * large.sine, kSmallRadius * small.sine});
    }
  }
  const auto vertex = [=](std::uint64_t i, std::uint64_t j) {
    return static_cast<VertexId>(i % around * across + j % across);
  };
  for (std::uint64_t i = 0; i < around; ++i) {
    for (std::uint64_t j = 0; j < across; ++j) {
      const VertexId here = vertex(i, j), beside = vertex(i + 1, j);
      const VertexId above = vertex(i, j + 1), across_from = vertex(i + 1, j + 1);
      // The direction of each diagonal is random, so that valences vary before any edge is
      // collapsed.
      if (random.unit() < 0.5) {
        mesh.faces.push_back({here, beside, across_from});
        mesh.faces.push_back({here, across_from, above});
      } else {
        mesh.faces.push_back({here, beside, above});
        mesh.faces.push_back({beside, across_from, above});
      }
    }
  }
  return mesh;
}

/// The nearest point of the torus.
Vector3<double> onto_torus(Vector3<double> p) {
  const double radius = std::sqrt(p.x * p.x + p.y * p.y);
  if (radius == 0) return p;
  const Vector3<double> centre{kLargeRadius / radius * p.x, kLargeRadius / radius * p.y, 0};
  return centre + kSmallRadius * normalized(p - centre);
}

}  // namespace

IndexedMesh make_torus(std::uint64_t vertices, std::uint64_t seed, const Progress& progress) {
  // A third more vertices than wanted, in cells that are about as wide as high.
  const double cells = static_cast<double>(vertices) * 4 / 3;
  const auto across =
      static_cast<std::uint64_t>(std::ceil(std::sqrt(cells * kSmallRadius / kLargeRadius)));
  const std::uint64_t rows = std::max<std::uint64_t>(across, 4);
  const std::uint64_t around =
      std::max<std::uint64_t>(static_cast<std::uint64_t>(cells) / rows + 1, 5);
  IndexedMesh mesh = torus_grid(around, rows, seed);
  progress(0.2);
  constexpr double kRandomness = 3;
  mesh = reduce(std::move(mesh), {vertices, seed, kRandomness}, progress.part(0.2, 0.9));
  constexpr int kSmoothingSteps = 3;
  for (int step = 0; step < kSmoothingSteps; ++step) {
    smooth(mesh, 0.5);
    for (Vector3<double>& position : mesh.positions) position = onto_torus(position);
  }
  return mesh;
}

}  // namespace generation
PLAIT_END_NAMESPACE
