// collapse/tiles.h: parts of a surface that threads work on at once.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "plait/detail/namespace.h"
#include "surface/surface.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// The most faces of a tile, so that what the collapses inside need fits into the caches.
constexpr std::size_t kTileFaces = std::size_t{1} << 16;

/// Divides the faces into halves along the longest axis, again and again. [tile] faces, ascending.
/// The tiles depend on the surface alone. Pinned by tests/scans/decimate_test.cpp.
std::vector<std::vector<FaceId>> face_tiles(std::span<const Point> positions,
                                            std::span<const std::array<VertexId, 3>> faces,
                                            std::size_t tile_faces = kTileFaces);

/// [vertex] the tile that all its faces are in; kNoId if they are in several, or there are none.
std::vector<std::uint32_t> vertex_tiles(std::size_t vertices,
                                        std::span<const std::array<VertexId, 3>> faces,
                                        std::span<const std::vector<FaceId>> tiles);

PLAIT_END_NAMESPACE
