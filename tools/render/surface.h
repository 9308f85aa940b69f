// render/surface.h: draws one level of a store into a z-buffer, patch by patch.
#pragma once

#include <cstdint>
#include <functional>

#include "plait/store.h"
#include "render/camera.h"
#include "render/sample_buffer.h"

namespace plait {

/// A camera that fits the surface into width x height samples. Vertices are read up to the finest
/// level that has a few million of them, through the pager. Errors: as draw_surface.
Camera fitting_camera(Store& store, int level, const ViewAngles& view, UpAxis up, int width,
                      int height);

/// Draws all faces in layout order. Normals come from attribute "normal" where it reaches the
/// level, else from the triangles around each vertex. Memory beside the store's budget: two rows
/// of one patch, and one normal a base vertex in the second case.
/// Errors: kInvalidArgument for a level that is not there and for positions that are no points;
/// kCancelled; those of Session::pin.
void draw_surface(Store& store, int level, const Camera& camera, SampleBuffer& samples,
                  const std::function<bool(std::uint64_t done, std::uint64_t total)>& proceed);

}  // namespace plait
