#include "render/sample_buffer.h"

#include <algorithm>
#include <cmath>

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr int kSubSampleBits = 8;
constexpr std::int32_t kSubSamples = 1 << kSubSampleBits;
constexpr float kNormalScale = 32767;
/// A share of 1; one more is a sample without a share.
constexpr std::uint16_t kWholeShare = 65534;
/// Far outside every picture, but small enough for products in 64 bits.
constexpr double kMaxCoordinate = 1 << 26;

std::int32_t to_fixed(double coordinate) {
  return static_cast<std::int32_t>(
      std::lround(std::clamp(coordinate * kSubSamples, -kMaxCoordinate, kMaxCoordinate)));
}

/// The first and the last sample whose centre lies in [low, high].
std::int32_t first_sample(std::int32_t low) {
  return (low + kSubSamples / 2 - 1) >> kSubSampleBits;
}
std::int32_t last_sample(std::int32_t high) { return (high - kSubSamples / 2) >> kSubSampleBits; }

std::int64_t twice_area(const RasterVertex& a, const RasterVertex& b, std::int64_t x,
                        std::int64_t y) {
  return (std::int64_t{b.x} - a.x) * (y - a.y) - (std::int64_t{b.y} - a.y) * (x - a.x);
}

PixelSample encode_sample(float nearness, Vector3<float> normal, bool back) {
  if (back) normal = -1.f * normal;
  // At the outline, an interpolated normal may point slightly away from the camera.
  normal.z = std::max(normal.z, 0.f);
  normal = normalized(normal);
  const auto x = static_cast<std::int16_t>(std::lround(normal.x * kNormalScale));
  const auto y = static_cast<int>(std::lround(normal.y * kNormalScale));
  return {nearness, x, static_cast<std::int16_t>((y & ~1) | (back ? 1 : 0))};
}

std::uint16_t encode_share(float share) {
  if (!std::isfinite(share)) return kWholeShare + 1;
  return static_cast<std::uint16_t>(std::lround(std::clamp(share, 0.f, 1.f) * kWholeShare));
}

}  // namespace

Vector3<float> PixelSample::normal() const {
  const float x = static_cast<float>(normal_x) / kNormalScale;
  const float y = static_cast<float>(normal_y & ~1) / kNormalScale;
  return {x, y, std::sqrt(std::max(0.f, 1 - x * x - y * y))};
}

RasterVertex raster_vertex(const ScreenPoint& point, const Vector3<float>& normal) {
  return {to_fixed(point.x), to_fixed(point.y), static_cast<float>(point.nearness), normal, 0};
}

SampleBuffer::SampleBuffer(int width, int height, bool shares)
    : width_(width),
      height_(height),
      samples_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height)),
      shares_(shares ? samples_.size() : 0) {}

double SampleBuffer::share(int x, int y) const {
  const std::uint16_t share =
      shares_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
              static_cast<std::size_t>(x)];
  return share > kWholeShare ? -1 : static_cast<double>(share) / kWholeShare;
}

void SampleBuffer::draw(const RasterVertex& a, const RasterVertex& b, const RasterVertex& c) {
  const std::int32_t x_first = std::max(first_sample(std::min({a.x, b.x, c.x})), 0);
  const std::int32_t x_last = std::min(last_sample(std::max({a.x, b.x, c.x})), width_ - 1);
  const std::int32_t y_first = std::max(first_sample(std::min({a.y, b.y, c.y})), 0);
  const std::int32_t y_last = std::min(last_sample(std::max({a.y, b.y, c.y})), height_ - 1);
  // At fine levels most triangles contain no sample.
  if (x_first > x_last || y_first > y_last) return;
  std::int64_t area = twice_area(a, b, c.x, c.y);
  if (area == 0) return;
  // Because y points down, a positive area is clockwise on the screen: the back of the triangle.
  const bool back = area > 0;
  const RasterVertex& second = back ? b : c;
  const RasterVertex& third = back ? c : b;
  area = std::abs(area);
  const float scale = 1 / static_cast<float>(area);

  for (std::int32_t y = y_first; y <= y_last; ++y) {
    const std::int64_t centre_y = std::int64_t{y} * kSubSamples + kSubSamples / 2;
    PixelSample* row = &samples_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_)];
    for (std::int32_t x = x_first; x <= x_last; ++x) {
      const std::int64_t centre_x = std::int64_t{x} * kSubSamples + kSubSamples / 2;
      const std::int64_t weight_a = twice_area(second, third, centre_x, centre_y);
      const std::int64_t weight_b = twice_area(third, a, centre_x, centre_y);
      const std::int64_t weight_c = area - weight_a - weight_b;
      if ((weight_a | weight_b | weight_c) < 0) continue;
      const float u = scale * static_cast<float>(weight_a);
      const float v = scale * static_cast<float>(weight_b);
      const float w = scale * static_cast<float>(weight_c);
      const float nearness = u * a.nearness + v * second.nearness + w * third.nearness;
      if (nearness <= row[x].nearness) continue;
      row[x] = encode_sample(nearness, u * a.normal + v * second.normal + w * third.normal, back);
      if (has_shares())
        shares_[static_cast<std::size_t>(row + x - samples_.data())] =
            encode_share(u * a.share + v * second.share + w * third.share);
    }
  }
}

PLAIT_END_NAMESPACE
