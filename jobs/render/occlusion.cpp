#include "render/occlusion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr int kTaps = 12;
constexpr int kTurns = 5;  // of the spiral; has no common divisor with kTaps
constexpr int kTile = 4;
constexpr std::size_t kSpirals = 16;  // kTile squared
constexpr float kStrength = 7.5f;     // chosen by eye
// In radii of the surface: for creases and for caves.
constexpr std::array<float, 2> kReaches = {0.09f, 0.40f};
// In units of the reach. With less, a flat surface would darken itself.
constexpr float kBias = 0.02f;

struct Tap {
  float x, y;  // in units of the reach
};
using Spirals = std::array<std::array<Tap, kTaps>, kSpirals>;

Spirals make_spirals() {
  Spirals spirals{};
  for (std::size_t turn = 0; turn < spirals.size(); ++turn)
    for (std::size_t tap = 0; tap < kTaps; ++tap) {
      const float shift = (static_cast<float>(turn) + 0.5f) / kSpirals;
      const float share = (static_cast<float>(tap) + shift) / kTaps;
      const float angle = 2 * std::numbers::pi_v<float> * (share * kTurns + shift);
      spirals[turn][tap] = {share * std::cos(angle), share * std::sin(angle)};
    }
  return spirals;
}

/// The nearest sample of a pixel. If all samples are empty, the result is an empty one.
const PixelSample& nearest_sample(const SampleBuffer& samples, int column, int row) {
  const PixelSample* nearest = &samples.at(column * kSamplesPerSide, row * kSamplesPerSide);
  for (int y = 0; y < kSamplesPerSide; ++y)
    for (int x = 0; x < kSamplesPerSide; ++x) {
      const PixelSample& sample =
          samples.at(column * kSamplesPerSide + x, row * kSamplesPerSide + y);
      if (sample.nearness > nearest->nearness) nearest = &sample;
    }
  return *nearest;
}

float hidden_share(const SampleBuffer& samples, const Camera& camera,
                   const std::array<Tap, kTaps>& spiral, const PixelSample& sample, float x,
                   float y, float radius) {
  const Vector3<float> normal = sample.normal();
  const Vector3<float> centre = camera.unproject(x, y, sample.nearness);
  const float screen_radius = radius * sample.nearness;
  float sum = 0;
  for (const Tap& tap : spiral) {
    const int column = static_cast<int>(x + screen_radius * tap.x);
    const int row = static_cast<int>(y + screen_radius * tap.y);
    if (column < 0 || row < 0 || column >= samples.width() || row >= samples.height()) continue;
    const PixelSample& other = samples.at(column, row);
    if (other.empty()) continue;
    const Vector3<float> there = camera.unproject(static_cast<float>(column) + 0.5f,
                                                  static_cast<float>(row) + 0.5f, other.nearness);
    const Vector3<float> way = (1 / radius) * (there - centre);
    const float square = dot(way, way);
    const float falloff = std::max(0.f, 1 - square);
    sum += falloff * falloff * falloff * std::max(0.f, dot(way, normal) - kBias) / (square + 0.01f);
  }
  return kStrength / kTaps * sum;
}

}  // namespace

SkyMap::SkyMap(const SampleBuffer& samples, const Camera& camera, const RowWorkers& workers)
    : width_(samples.width() / kSamplesPerSide), height_(samples.height() / kSamplesPerSide) {
  const Spirals spirals = make_spirals();
  std::vector<float> rough(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_),
                           1.f);
  share_ = rough;
  parallel_rows(height_, workers, [&](int row) {
    for (int column = 0; column < width_; ++column) {
      const PixelSample& sample = nearest_sample(samples, column, row);
      if (sample.empty()) continue;
      // Each row of the tile uses every fourth of the sixteen turns, so that neighbouring pixels
      // differ much.
      const int turn = (column % kTile) * kTile + row % kTile;
      const float x = (static_cast<float>(column) + 0.5f) * kSamplesPerSide;
      const float y = (static_cast<float>(row) + 0.5f) * kSamplesPerSide;
      float share = 1;
      for (const float reach : kReaches)
        share *= std::exp(-hidden_share(samples, camera, spirals[static_cast<std::size_t>(turn)],
                                        sample, x, y, reach * camera.radius()));
      rough[index(column, row)] = share;
    }
  });
  // If the depths of two pixels differ by more than on a steep surface, they show two surfaces.
  const float tolerance = 0.02f;
  parallel_rows(height_, workers, [&](int row) {
    for (int column = 0; column < width_; ++column)
      share_[index(column, row)] = tile_mean(samples, rough, tolerance, column, row);
  });
}

float SkyMap::tile_mean(const SampleBuffer& samples, const std::vector<float>& rough,
                        float tolerance, int column, int row) const {
  const float nearness = nearest_sample(samples, column, row).nearness;
  if (nearness == 0) return 1;
  float sum = 0, weights = 0;
  for (int y = std::max(0, row - kTile / 2); y < std::min(height_, row + kTile / 2); ++y)
    for (int x = std::max(0, column - kTile / 2); x < std::min(width_, column + kTile / 2); ++x) {
      const float other = nearest_sample(samples, x, y).nearness;
      if (std::abs(other - nearness) > tolerance) continue;
      sum += rough[index(x, y)];
      weights += 1;
    }
  return sum / weights;
}

PLAIT_END_NAMESPACE
