// layout/spans.h: spans of an order of faces before the mesh is put into it.
#pragma once

#include <span>
#include <vector>

#include "plait/layout.h"

namespace plait::layout {

/// number[edge] = its number by first use when the faces come in `order` (order[new] = old): the
/// numbers that BaseMesh::with_face_order gives.
std::vector<EdgeId> number_edges(const BaseMesh& mesh, std::span<const FaceId> order);

/// measure_spans with every edge called by its number.
LayoutSpans measure_spans(const BaseMesh& mesh, std::span<const EdgeId> number);

/// LayoutSpans::loop.span alone: all that a choice needs, for a fraction of the time.
std::uint64_t measure_loop_span(const BaseMesh& mesh, std::span<const EdgeId> number);

}  // namespace plait::layout
