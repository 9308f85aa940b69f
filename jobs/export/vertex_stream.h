// export/vertex_stream.h: reads the records of several attributes in the order of the numbers of a
// PatchSelection. One block of each attribute is pinned at a time.
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <vector>

#include "export/patch_selection.h"
#include "plait/detail/namespace.h"
#include "plait/store.h"

PLAIT_BEGIN_NAMESPACE

/// Receives the records of consecutive vertices: [attribute] the bytes of `count` records.
using VertexSink =
    std::function<void(std::span<const std::span<const std::byte>> records, std::size_t count)>;

/// Calls `sink` with all vertices of the patches, at most one slot per call. Errors: those of
/// Session::pin and of `sink`.
void stream_vertices(Store& store, std::span<const AttributeId> attributes,
                     const PatchSelection& patches, const VertexSink& sink);
/// The same for all patches of `level` (counted from the user's mesh).
void stream_vertices(Store& store, std::span<const AttributeId> attributes, int level,
                     const VertexSink& sink);

PLAIT_END_NAMESPACE
