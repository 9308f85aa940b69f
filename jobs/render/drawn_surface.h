// render/drawn_surface.h: draws a store whose faces have depths of their own into a z-buffer.
#pragma once

#include "plait/progress.h"
#include "plait/store.h"
#include "render/camera.h"
#include "render/sample_buffer.h"
#include "render/surface.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Draws the triangles that close the sides between deep and shallow faces
/// (plait/detail/drawn_triangles.h), up to a level. Normals come from the attribute "normal" if it
/// has this level, otherwise from the triangles around each vertex, wherever these are. Memory
/// beside the store's budget: 40 bytes for each vertex, and with made normals 24 more. Errors:
/// kOutOfMemory if that is more than there is; those of draw_surface(). REQUIRES: as
/// draw_surface(), which calls it.
void draw_drawn_surface(Store& store, AttributeId position, int level, const Camera& camera,
                        SampleBuffer& samples, const ProgressCallback& progress,
                        const ColorBy& color_by);

PLAIT_END_NAMESPACE
