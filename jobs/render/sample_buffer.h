// render/sample_buffer.h: the z-buffer. It stores the nearest surface and its normal for every
// sample, in eight bytes. After all triangles are drawn, shade() makes the picture from it.
#pragma once

#include <cstdint>
#include <vector>

#include "plait/extend/vector3.h"
#include "render/camera.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

struct PixelSample {
  float nearness = 0;  ///< 0: no surface at this sample
  /// The normal, towards the camera, in units of 1/32767. Its length is one, which gives z. The
  /// lowest bit of y is set if the camera sees the back of the surface.
  std::int16_t normal_x = 0, normal_y = 0;

  bool empty() const { return nearness == 0; }
  bool is_back() const { return (normal_y & 1) != 0; }
  Vector3<float> normal() const;
};
static_assert(sizeof(PixelSample) == 8);

/// A projected vertex: position in 1/256 of a sample, so that coverage is exact and two triangles
/// leave no gap between them.
struct RasterVertex {
  std::int32_t x = 0, y = 0;
  float nearness = 0;
  Vector3<float> normal{};  ///< camera axes
  float share = 0;          ///< of the colour scale
};
RasterVertex raster_vertex(const ScreenPoint& point, const Vector3<float>& normal);

/// One thread.
class SampleBuffer {
 public:
  /// With `shares`, the buffer also keeps two bytes for each sample: its place on a colour scale.
  SampleBuffer(int width, int height, bool shares = false);

  int width() const { return width_; }
  int height() const { return height_; }
  const PixelSample& at(int x, int y) const {
    return samples_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
                    static_cast<std::size_t>(x)];
  }
  bool has_shares() const { return !shares_.empty(); }
  /// From 0 to 1; less than 0 if a corner has none. REQUIRES: has_shares(), a sample that is not
  /// empty.
  double share(int x, int y) const;
  /// Draws a triangle; the nearer surface stays. Both sides of a triangle are drawn. If its corners
  /// are counterclockwise on the screen, its front faces the camera.
  void draw(const RasterVertex& a, const RasterVertex& b, const RasterVertex& c);

 private:
  int width_, height_;
  std::vector<PixelSample> samples_;
  std::vector<std::uint16_t> shares_;
};

PLAIT_END_NAMESPACE
