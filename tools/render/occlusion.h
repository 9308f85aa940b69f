// render/occlusion.h: how much of the sky each pixel sees, from the z-buffer alone.
#pragma once

#include <vector>

#include "render/camera.h"
#include "render/sample_buffer.h"

namespace plait {

/// One pixel from each square of kSamplesPerSide x kSamplesPerSide samples.
constexpr int kSamplesPerSide = 2;

/// 0 (none of it) to 1 (all that the surface faces) for every pixel. Eight bytes a pixel while it
/// is made, four after. Source: M. McGuire, M. Mara, D. Luebke, "Scalable Ambient Obscurance",
/// 2012, section 2: taps on a spiral. The spiral has sixteen turns, one for each pixel of a 4 x 4
/// tile, and a mean over such tiles, which keeps to one surface, takes the pattern out again.
class SkyMap {
 public:
  SkyMap(const SampleBuffer& samples, const Camera& camera, int threads);
  float at(int column, int row) const { return share_[index(column, row)]; }

 private:
  std::size_t index(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(width_) +
           static_cast<std::size_t>(column);
  }
  float tile_mean(const SampleBuffer& samples, const std::vector<float>& rough, float tolerance,
                  int column, int row) const;

  int width_, height_;
  std::vector<float> share_;
};

}  // namespace plait
