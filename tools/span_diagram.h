// tools/span_diagram.h: draws which edges the stencils of a mesh use.
#pragma once

#include "picture/image.h"
#include "plait/base_mesh.h"
#include "plait/extend/file.h"

namespace plait {

/// Two panels side by side: the face stencils and the Loop stencils (layout.h). A panel has a row
/// for each stencil, in layout order from top to bottom. The row has a dot for each edge that the
/// stencil uses, by edge index from left to right. If there are more stencils or edges than pixels,
/// a pixel with more dots is darker. A layout with a small span gives a narrow band along the
/// diagonal. Source: I. Guskov, "Non-replicating indexing for out-of-core processing of
/// semi-regular triangular surface meshes", figures 6 and 7.
/// Errors: kInvalidArgument for a mesh without faces.
Image span_diagram(const BaseMesh& mesh);

/// Writes span_diagram() as a PNG file. Errors: also those of write_png.
void draw_span_diagram(const BaseMesh& mesh, File& file);

}  // namespace plait
