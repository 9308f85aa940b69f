// render/occlusion.h: computes how much of the sky each pixel sees, from the z-buffer alone.
#pragma once

#include <vector>

#include "render/camera.h"
#include "render/parallel_rows.h"
#include "render/sample_buffer.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// A pixel is a square of kSamplesPerSide x kSamplesPerSide samples.
constexpr int kSamplesPerSide = 2;

/// For every pixel a number from 0 (sees no sky) to 1 (sees all the sky that its surface faces).
/// Eight bytes per pixel during construction, four after. Source: M. McGuire, M. Mara, D. Luebke,
/// "Scalable Ambient Obscurance", 2012, section 2: taps on a spiral. The pixels of a 4 x 4 tile use
/// sixteen rotations of the spiral. A mean over such tiles removes the pattern that the rotations
/// cause; it includes only pixels of the same surface.
class SkyMap {
 public:
  SkyMap(const SampleBuffer& samples, const Camera& camera, const RowWorkers& workers);
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

PLAIT_END_NAMESPACE
