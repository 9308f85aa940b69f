// render/shading.h: from the z-buffer to the picture: a key and a fill light, a bright sky with
// ambient occlusion, one soft material, a light background.
#pragma once

#include "picture/image.h"
#include "render/camera.h"
#include "render/occlusion.h"
#include "render/sample_buffer.h"

namespace plait {

/// Shades every sample and averages each kSamplesPerSide x kSamplesPerSide of them in linear
/// light. Eight bytes a pixel beside the image. The result does not depend on `threads`.
Image shade(const SampleBuffer& samples, const Camera& camera, int threads);

}  // namespace plait
