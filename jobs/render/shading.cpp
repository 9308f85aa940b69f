#include "render/shading.h"

#include <algorithm>
#include <cmath>

#include "picture/color_map.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

using Colour = Vector3<float>;  // linear light, 0 to 1

Colour operator*(const Colour& a, const Colour& b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }

struct Light {
  Vector3<float> direction;  // camera axes, towards the light; unit length
  Colour colour;
  float wrap;  // how far the light goes around the surface; 0 is Lambert's cosine
};

const Light kKey{normalized(Vector3<float>{-0.50f, 0.62f, 0.60f}), {1.00f, 0.95f, 0.88f}, 0.15f};
const Light kFill{normalized(Vector3<float>{0.80f, 0.05f, 0.45f}), {0.20f, 0.25f, 0.33f}, 0.35f};
const Colour kSky{0.46f, 0.50f, 0.56f}, kGround{0.20f, 0.17f, 0.16f};
const Colour kFront{0.13f, 0.36f, 0.44f};  // sea green
const Colour kBack{0.60f, 0.38f, 0.22f};   // sand, so that the back is easy to see
const Colour kTop{0.945f, 0.950f, 0.955f}, kBottom{0.70f, 0.73f, 0.77f};  // background
constexpr float kShine = 0.16f, kShininess = 42, kOutlineShine = 0.30f;
constexpr float kInterreflection = 0.55f;
constexpr float kScaleStrength = 0.8f;  // the lights together are brighter than 1

float lit(const Light& light, const Vector3<float>& normal) {
  return std::max(0.f, (dot(normal, light.direction) + light.wrap) / (1 + light.wrap));
}

Colour background(float height) { return (1 - height) * kTop + height * kBottom; }

/// Where the surface does not see the sky, it gets light that the surface nearby reflects, in the
/// surface's colour.
Colour sky_light(float sky, const Colour& albedo) {
  return sky * Colour{1, 1, 1} + ((1 - sky) * kInterreflection) * albedo;
}

Colour shade_sample(const PixelSample& sample, float sky, const Colour& albedo) {
  const Vector3<float> normal = sample.normal();
  const float up = 0.5f + 0.5f * normal.y;
  const Colour ambient = sky_light(sky, albedo) * ((1 - up) * kGround + up * kSky);
  // Creases also get less light from the two lamps, because lamps are not points.
  const float open = 0.3f + 0.7f * sky;
  const Colour direct =
      (open * lit(kKey, normal)) * kKey.colour + (open * lit(kFill, normal)) * kFill.colour;
  Colour colour = albedo * (ambient + direct);

  const Vector3<float> half = normalized(kKey.direction + Vector3<float>{0, 0, 1});
  const float shine = kShine * open * std::pow(std::max(0.f, dot(normal, half)), kShininess);
  const float grazing = std::pow(1 - normal.z, 4.f);
  return colour + shine * kKey.colour + (kOutlineShine * sky * grazing * up) * kSky;
}

/// sRGB to linear light, and back (IEC 61966-2-1).
float decode(std::uint8_t encoded) {
  const float value = static_cast<float>(encoded) / 255;
  return value <= 0.04045f ? value / 12.92f : std::pow((value + 0.055f) / 1.055f, 2.4f);
}
std::uint8_t encode_srgb(float linear) {
  const float value = std::clamp(linear, 0.f, 1.f);
  const float srgb =
      value <= 0.0031308f ? 12.92f * value : 1.055f * std::pow(value, 1 / 2.4f) - 0.055f;
  return static_cast<std::uint8_t>(std::lround(255 * srgb));
}

/// The colour of a sample's material.
Colour albedo_of(const SampleBuffer& samples, int x, int y) {
  if (!samples.has_shares()) return samples.at(x, y).is_back() ? kBack : kFront;
  const double share = samples.share(x, y);
  const Rgb color = share < 0 ? kNoNumberColor : color_of_share(share);
  return kScaleStrength * Colour{decode(color.red), decode(color.green), decode(color.blue)};
}

}  // namespace

Image shade(const SampleBuffer& samples, const Camera& camera, const RowWorkers& workers) {
  const SkyMap sky(samples, camera, workers);
  const int width = samples.width() / kSamplesPerSide, height = samples.height() / kSamplesPerSide;
  Image image(static_cast<std::size_t>(width), static_cast<std::size_t>(height), Rgb{0, 0, 0});
  parallel_rows(height, workers, [&](int row) {
    const Colour behind =
        background(static_cast<float>(row) / static_cast<float>(std::max(1, height - 1)));
    for (int column = 0; column < width; ++column) {
      Colour sum{};
      for (int y = row * kSamplesPerSide; y < (row + 1) * kSamplesPerSide; ++y)
        for (int x = column * kSamplesPerSide; x < (column + 1) * kSamplesPerSide; ++x) {
          const PixelSample& sample = samples.at(x, y);
          sum = sum + (sample.empty()
                           ? behind
                           : shade_sample(sample, sky.at(column, row), albedo_of(samples, x, y)));
        }
      const Colour mean = (1.f / (kSamplesPerSide * kSamplesPerSide)) * sum;
      image.at(static_cast<std::size_t>(column), static_cast<std::size_t>(row)) = {
          encode_srgb(mean.x), encode_srgb(mean.y), encode_srgb(mean.z)};
    }
  });
  return image;
}

PLAIT_END_NAMESPACE
