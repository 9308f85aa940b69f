#include "collapse/tiles.h"

#include <algorithm>
#include <numeric>

#include "base/interruption.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

void divide(std::span<FaceId> faces, std::span<const Point> middles, std::size_t tile_faces,
            std::vector<std::vector<FaceId>>& tiles) {
  if (faces.size() <= tile_faces) {
    tiles.emplace_back(faces.begin(), faces.end());
    std::sort(tiles.back().begin(), tiles.back().end());
    return;
  }
  poll_interruption();
  Point low = middles[faces[0]], high = low;
  for (const FaceId face : faces)
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], middles[face][axis]);
      high[axis] = std::max(high[axis], middles[face][axis]);
    }
  int longest = 0;
  for (int axis = 1; axis < 3; ++axis)
    if (high[axis] - low[axis] > high[longest] - low[longest]) longest = axis;
  const std::size_t half = faces.size() / 2;
  std::nth_element(faces.begin(), faces.begin() + static_cast<std::ptrdiff_t>(half), faces.end(),
                   [&](FaceId a, FaceId b) {
                     return middles[a][longest] != middles[b][longest]
                                ? middles[a][longest] < middles[b][longest]
                                : a < b;
                   });
  divide(faces.first(half), middles, tile_faces, tiles);
  divide(faces.subspan(half), middles, tile_faces, tiles);
}

}  // namespace

std::vector<std::vector<FaceId>> face_tiles(std::span<const Point> positions,
                                            std::span<const std::array<VertexId, 3>> faces,
                                            std::size_t tile_faces) {
  std::vector<FaceId> order(faces.size());
  std::iota(order.begin(), order.end(), FaceId{0});
  std::vector<Point> middles(faces.size());
  for (std::size_t face = 0; face < faces.size(); ++face)
    middles[face] =
        positions[faces[face][0]] + positions[faces[face][1]] + positions[faces[face][2]];
  std::vector<std::vector<FaceId>> tiles;
  divide(order, middles, std::max<std::size_t>(tile_faces, 1), tiles);
  return tiles;
}

std::vector<std::uint32_t> vertex_tiles(std::size_t vertices,
                                        std::span<const std::array<VertexId, 3>> faces,
                                        std::span<const std::vector<FaceId>> tiles) {
  std::vector<std::uint32_t> result(vertices, kNoId);
  std::vector<std::uint8_t> shared(vertices, 0);
  for (std::size_t tile = 0; tile < tiles.size(); ++tile)
    for (const FaceId face : tiles[tile])
      for (const VertexId vertex : faces[face]) {
        if (result[vertex] != kNoId && result[vertex] != tile) shared[vertex] = 1;
        result[vertex] = static_cast<std::uint32_t>(tile);
      }
  for (std::size_t vertex = 0; vertex < vertices; ++vertex)
    if (shared[vertex] != 0) result[vertex] = kNoId;
  return result;
}

PLAIT_END_NAMESPACE
