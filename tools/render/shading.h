// render/shading.h: makes the picture from the z-buffer, with a key light, a fill light, a bright
// sky with ambient occlusion, one soft material and a light background.
#pragma once

#include "picture/image.h"
#include "render/camera.h"
#include "render/occlusion.h"
#include "render/sample_buffer.h"

namespace plait {

/// Shades every sample, in the colours of the scale if the buffer has shares. A pixel is the mean
/// of its kSamplesPerSide x kSamplesPerSide samples in linear light. Memory: eight bytes per pixel
/// in addition to the image. The result does not depend on `threads`.
Image shade(const SampleBuffer& samples, const Camera& camera, int threads);

}  // namespace plait
