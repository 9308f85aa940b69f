// layout/spans.h: the spans that a mesh would have in an order of faces, without reordering the
// mesh.
#pragma once

#include <span>
#include <vector>

#include "plait/layout.h"

namespace plait::layout {

/// number[edge] = the number that BaseMesh::with_face_order(order) gives to the edge: by first use,
/// with the faces in `order` (order[new] = old).
std::vector<EdgeId> number_edges(const BaseMesh& mesh, std::span<const FaceId> order);

/// measure_spans, with number[edge] in place of every edge.
LayoutSpans measure_spans(const BaseMesh& mesh, std::span<const EdgeId> number);

/// LayoutSpans::loop.span alone. It takes a fraction of the time and is enough to choose a layout.
std::uint64_t measure_loop_span(const BaseMesh& mesh, std::span<const EdgeId> number);

}  // namespace plait::layout
