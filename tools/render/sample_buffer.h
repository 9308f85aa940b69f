// render/sample_buffer.h: the z-buffer: for every sample the nearest surface and its normal. Eight
// bytes a sample; the picture is shaded from it when all triangles are in.
#pragma once

#include <cstdint>
#include <vector>

#include "plait/vector3.h"
#include "render/camera.h"

namespace plait {

struct Sample {
  float nearness = 0;  ///< 0: nothing here
  /// The normal towards the camera, 32767 to one; z is what is left of the length. The lowest bit
  /// of y says that the back of the surface is seen.
  std::int16_t normal_x = 0, normal_y = 0;

  bool empty() const { return nearness == 0; }
  bool is_back() const { return (normal_y & 1) != 0; }
  Vector3<float> normal() const;
};
static_assert(sizeof(Sample) == 8);

/// A projected vertex: position in 1/256 of a sample, so that coverage is exact and two triangles
/// leave no gap between them.
struct RasterVertex {
  std::int32_t x = 0, y = 0;
  float nearness = 0;
  Vector3<float> normal{};  ///< camera axes
};
RasterVertex raster_vertex(const ScreenPoint& point, const Vector3<float>& normal);

/// One thread.
class SampleBuffer {
 public:
  SampleBuffer(int width, int height);

  int width() const { return width_; }
  int height() const { return height_; }
  const Sample& at(int x, int y) const {
    return samples_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
                    static_cast<std::size_t>(x)];
  }
  /// Keeps what is nearer. Both sides are drawn; counterclockwise ones face the camera.
  void draw(const RasterVertex& a, const RasterVertex& b, const RasterVertex& c);

 private:
  int width_, height_;
  std::vector<Sample> samples_;
};

}  // namespace plait
