// picture/span_diagram.h: which edges the stencils of a mesh use, as a picture.
#pragma once

#include "picture/image.h"
#include "plait/base_mesh.h"
#include "plait/file.h"

namespace plait {

/// Two panels side by side: the face stencils and the Loop stencils (layout.h). A panel has a row
/// for each stencil, in layout order downwards, and in it a dot for each edge used, by edge index
/// from left to right; where there are more stencils or edges than pixels, a pixel is the darker
/// the more dots it takes. A narrow band along the diagonal is a layout of small span. Source: I.
/// Guskov, "Non-replicating indexing for out-of-core processing of semi-regular triangular surface
/// meshes", figures 6 and 7.
/// Errors: kInvalidArgument for a mesh without faces.
Image span_diagram(const BaseMesh& mesh);

/// span_diagram as a PNG file. Errors: those of write_png too.
void draw_span_diagram(const BaseMesh& mesh, File& file);

}  // namespace plait
