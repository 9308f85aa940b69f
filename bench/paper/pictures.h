// bench/paper/pictures.h: Figures 5 to 7 of the paper, from a mesh.
#pragma once

#include "picture/image.h"
#include "plait/base_mesh.h"
#include "plait/layout.h"

namespace plait::paper {

/// Figure 5: the mesh, and beside it its Loop surface at `level`, shaded as `plait render` does.
/// Memory: the surface. Errors: kCancelled after a signal.
Image surface_picture(const BaseMesh& mesh, int level, int threads);

/// Figures 6 and 7: the span diagram of the mesh in the given order, at most so many pixels wide.
Image span_picture(const BaseMesh& mesh, LayoutKind order, std::size_t most_width);

/// The picture with half the width and height; each pixel is the mean of four. An odd last row or
/// column is left out. REQUIRES: at least 2 x 2 pixels.
Image halved(const Image& image);

}  // namespace plait::paper
