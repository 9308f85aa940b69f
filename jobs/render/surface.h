// render/surface.h: draws one level of a store into a z-buffer, patch by patch.
#pragma once

#include <cstdint>
#include <string>

#include "plait/progress.h"
#include "plait/store.h"
#include "render/camera.h"
#include "render/sample_buffer.h"
#include "render/scalar.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// A camera that fits the surface into width x height samples. The function reads vertices up to
/// the finest level that has only a few million vertices. Errors: as draw_surface.
Camera fitting_camera(Store& store, int level, const ViewAngles& view, UpAxis up, int width,
                      int height);

/// The attribute that colours a picture.
struct ColorBy {
  std::string attribute;  ///< empty: none
  ScalarRange range;
  bool is_depth = false;  ///< the depths of faces, not an attribute

  /// The place of a number on the colour scale.
  float share(double number) const {
    const double width = range.high - range.low;
    return static_cast<float>((number - range.low) / (width > 0 ? width : 1));
  }
};

/// Draws all faces in layout order, and those with depths of their own as render/drawn_surface.h
/// says. Normals come from the attribute "normal" if it has this level,
/// otherwise from the triangles around each vertex. Memory beside the store's budget: two rows of
/// one patch and, in the second case, one normal per base vertex.
/// Errors: kInvalidArgument for a level that the store does not have, and for positions that are
/// not 3 numbers; kCancelled; those of Session::pin.
void draw_surface(Store& store, int level, const Camera& camera, SampleBuffer& samples,
                  const ProgressCallback& progress, const ColorBy& color_by = {});

PLAIT_END_NAMESPACE
