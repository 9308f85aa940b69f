#include "generate/marching_tetrahedra.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "generate/random.h"
#include "plait/progress.h"

using namespace plait;
using namespace plait::generation;

namespace {

const GeneratorProgress kSilent = [](double) {};

double volume(const IndexedMesh& mesh) {
  double sum = 0;
  for (const auto& [a, b, c] : mesh.faces)
    sum += dot(mesh.positions[a], cross(mesh.positions[b], mesh.positions[c])) / 6;
  return sum;
}

}  // namespace

TEST_CASE("MarchTetrahedra_Ball_IsASphereOrientedOutwards") {
  constexpr std::size_t kPoints = 41;
  const Grid grid{{-1, -1, -1}, 2.0 / (kPoints - 1), kPoints, kPoints, kPoints};
  constexpr double kRadius = 0.8;
  const IndexedMesh ball = march_tetrahedra(
      grid, 0,
      [&](std::size_t z, std::span<float> values) {
        for (std::size_t y = 0; y < kPoints; ++y) {
          for (std::size_t x = 0; x < kPoints; ++x) {
            const Vector3<double> p =
                grid.origin + grid.spacing * Vector3<double>{static_cast<double>(x),
                                                             static_cast<double>(y),
                                                             static_cast<double>(z)};
            values[y * kPoints + x] = static_cast<float>(kRadius - std::sqrt(dot(p, p)));
          }
        }
      },
      generation::Progress(kSilent));
  const BaseMesh mesh = BaseMesh::build(ball);
  CHECK(mesh.border_edge_count() == 0);
  CHECK(mesh.vertex_count() + mesh.face_count() == mesh.edge_count() + 2);
  CHECK(volume(ball) == Approx(4.0 / 3 * 3.14159265 * kRadius * kRadius * kRadius).epsilon(0.01));
}

TEST_CASE("MarchTetrahedra_Noise_IsAClosedManifoldWhateverTheSigns") {
  // Every combination of signs around a cube occurs many times.
  constexpr std::size_t kPoints = 14;
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    Random random(seed);
    const IndexedMesh noise = march_tetrahedra(
        {{0, 0, 0}, 1, kPoints, kPoints, kPoints}, 0.5f,
        [&](std::size_t z, std::span<float> values) {
          for (std::size_t y = 0; y < kPoints; ++y) {
            for (std::size_t x = 0; x < kPoints; ++x) {
              const bool outermost = x == 0 || y == 0 || z == 0 || x == kPoints - 1 ||
                                     y == kPoints - 1 || z == kPoints - 1;
              values[y * kPoints + x] = outermost ? 0 : static_cast<float>(random.unit());
            }
          }
        },
        generation::Progress(kSilent));
    std::vector<std::string> warnings;
    const BaseMesh mesh = BaseMesh::build(noise, "noise", &warnings);
    CHECK(mesh.vertex_count() > 1000);
    CHECK(mesh.border_edge_count() == 0);
    CHECK(warnings.empty());
    CHECK(volume(noise) > 0);
  }
}
