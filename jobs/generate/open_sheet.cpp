#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "generate/kinds.h"
#include "generate/portable_math.h"
#include "generate/random.h"
#include "generate/reduce.h"
#include "generate/smoothing.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace generation {
namespace {

/// A sum of waves in random directions, each of about the same slope.
class Bumps {
 public:
  explicit Bumps(Random& random) {
    for (Wave& wave : waves_) {
      const SineCosine direction = portable_sine_cosine(random.unit());
      const double turns = random.between(0.3, 3.0);  // over the width of the sheet
      wave = {turns * direction.cosine, turns * direction.sine, random.unit(), 0.04 / turns};
    }
  }
  double height(double x, double y) const {
    double sum = 0;
    for (const Wave& wave : waves_)
      sum += wave.height * portable_sine_cosine(wave.x * x + wave.y * y + wave.phase).sine;
    return sum;
  }

 private:
  struct Wave {
    double x, y, phase, height;
  };
  std::array<Wave, 12> waves_;
};

/// A flat grid over [-1, 1] squared, deformed towards a disc so that the corners are round.
IndexedMesh flat_sheet(std::uint64_t side, Random& random) {
  IndexedMesh mesh;
  mesh.positions.reserve(side * side);
  mesh.faces.reserve(2 * (side - 1) * (side - 1));
  const double scale = 2 / static_cast<double>(side - 1);
  for (std::uint64_t j = 0; j < side; ++j) {
    for (std::uint64_t i = 0; i < side; ++i) {
      const double x = static_cast<double>(i) * scale - 1, y = static_cast<double>(j) * scale - 1;
      mesh.positions.push_back(
          {x * std::sqrt(1 - 0.35 * y * y), y * std::sqrt(1 - 0.35 * x * x), 0});
    }
  }
  for (std::uint64_t j = 0; j + 1 < side; ++j) {
    for (std::uint64_t i = 0; i + 1 < side; ++i) {
      const auto here = static_cast<VertexId>(j * side + i);
      const auto above = static_cast<VertexId>(here + side);
      if (random.unit() < 0.5) {
        mesh.faces.push_back({here, here + 1, above + 1});
        mesh.faces.push_back({here, above + 1, above});
      } else {
        mesh.faces.push_back({here, here + 1, above});
        mesh.faces.push_back({here + 1, above + 1, above});
      }
    }
  }
  return mesh;
}

}  // namespace

IndexedMesh make_open_sheet(std::uint64_t vertices, std::uint64_t seed, const Progress& progress) {
  Random random(seed);
  const auto side =
      static_cast<std::uint64_t>(std::ceil(std::sqrt(static_cast<double>(vertices) * 4 / 3)));
  IndexedMesh mesh = flat_sheet(std::max<std::uint64_t>(side, 3), random);
  progress(0.2);
  // The sheet is flat until the end: as long as no face turns over in the plane, the sheet cannot
  // fold.
  constexpr double kRandomness = 3;
  mesh = reduce(std::move(mesh), {vertices, seed, kRandomness}, progress.part(0.2, 0.9));
  constexpr int kSmoothingSteps = 2;
  for (int step = 0; step < kSmoothingSteps; ++step) smooth(mesh, 0.5);
  const Bumps bumps(random);
  for (Vector3<double>& p : mesh.positions) p.z = bumps.height(p.x, p.y);
  return mesh;
}

}  // namespace generation
PLAIT_END_NAMESPACE
