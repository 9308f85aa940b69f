// render/shading.h: makes the picture from the z-buffer, with a key light, a fill light, a bright
// sky with ambient occlusion, one soft material and a light background.
#pragma once

#include "picture/image.h"
#include "render/camera.h"
#include "render/occlusion.h"
#include "render/parallel_rows.h"
#include "render/sample_buffer.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Shades every sample, in the colours of the scale if the buffer has shares. A pixel is the mean
/// of its kSamplesPerSide x kSamplesPerSide samples in linear light. Memory: eight bytes per pixel
/// in addition to the image. The result does not depend on the
/// number of threads. Errors: as run_workers().
Image shade(const SampleBuffer& samples, const Camera& camera, const RowWorkers& workers);

PLAIT_END_NAMESPACE
