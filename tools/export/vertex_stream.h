// export/vertex_stream.h: the records of several attributes side by side, in the order of
// VertexNumbering, holding one block of each at a time.
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <vector>

#include "plait/store.h"

namespace plait {

/// Gets the records of consecutive vertices: [attribute] bytes of `count` records.
using VertexSink =
    std::function<void(std::span<const std::span<const std::byte>> records, std::size_t count)>;

/// Passes the vertices of levels up to `level` (counted from the mesh the user gave) to `sink`,
/// at most one slot at a time. Errors: those of Session::pin, and what the sink throws.
void stream_vertices(Store& store, std::span<const AttributeId> attributes, int level,
                     const VertexSink& sink);

}  // namespace plait
