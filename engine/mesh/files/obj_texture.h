// mesh/files/obj_texture.h: the texture coordinates that faces of an OBJ file give to their
// corners, as those of vertices.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "mesh/connectivity.h"
#include "plait/detail/namespace.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// A vertex has the coordinates of its first corner in the file. Coordinates and vertices may
/// follow the faces that name them. Pinned by tests/engine/mesh/attributed_mesh_test.cpp.
class ObjTexture {
 public:
  using Coordinates = std::array<float, 2>;

  void add_coordinates(Coordinates coordinates) { coordinates_.push_back(coordinates); }
  /// `number` counts from 1, or back from the last coordinates so far; 0: the corner has none.
  /// `vertices`: those so far.
  void add_corner(VertexId vertex, std::int64_t number, std::size_t vertices);

  struct Result {
    std::vector<Coordinates> coordinates;  ///< [vertex] empty unless each corner has some
    /// Vertices whose other corners have other coordinates than the first: those of a seam.
    std::uint64_t seam_vertices = 0;
  };
  /// REQUIRES: no corner has a vertex from `vertices` on. A vertex without corners gets 0.
  Result finish(std::size_t vertices);

 private:
  static constexpr std::uint32_t kNone = kNoId;
  struct Corner {
    VertexId vertex;
    std::uint32_t place;
  };
  void give(Corner corner);

  std::vector<Coordinates> coordinates_;
  std::vector<std::uint32_t> first_;  // [vertex] place in coordinates_
  /// Corners of vertices that were not there yet, and those that are not the first of a vertex.
  std::vector<Corner> early_, others_;
  bool is_whole_ = true;
};

inline void ObjTexture::add_corner(VertexId vertex, std::int64_t number, std::size_t vertices) {
  if (!is_whole_) return;
  const auto count = static_cast<std::int64_t>(coordinates_.size());
  const std::int64_t place = number < 0 ? count + number : number - 1;
  if (place < 0 || place >= std::int64_t{kNone}) {
    is_whole_ = false;
    return;
  }
  const Corner corner{vertex, static_cast<std::uint32_t>(place)};
  // A number without a vertex would take any amount of memory.
  if (vertex >= vertices)
    early_.push_back(corner);
  else
    give(corner);
}

inline void ObjTexture::give(Corner corner) {
  if (corner.vertex >= first_.size()) first_.resize(std::size_t{corner.vertex} + 1, kNone);
  if (first_[corner.vertex] == kNone)
    first_[corner.vertex] = corner.place;
  else if (first_[corner.vertex] != corner.place)
    others_.push_back(corner);
}

inline ObjTexture::Result ObjTexture::finish(std::size_t vertices) {
  for (const Corner& corner : early_) give(corner);
  const auto is_there = [&](std::uint32_t place) {
    return place == kNone || place < coordinates_.size();
  };
  if (!is_whole_ || first_.empty() || !std::ranges::all_of(first_, is_there) ||
      !std::ranges::all_of(others_, is_there, &Corner::place))
    return {};
  Result result{std::vector<Coordinates>(vertices), 0};
  for (std::size_t vertex = 0; vertex < first_.size(); ++vertex)
    if (first_[vertex] != kNone) result.coordinates[vertex] = coordinates_[first_[vertex]];
  std::erase_if(others_, [&](const Corner& corner) {
    return coordinates_[corner.place] == result.coordinates[corner.vertex];
  });
  std::ranges::sort(others_, {}, &Corner::vertex);
  const auto end = std::unique(
      others_.begin(), others_.end(),
      [](const Corner& one, const Corner& other) { return one.vertex == other.vertex; });
  result.seam_vertices = static_cast<std::uint64_t>(end - others_.begin());
  return result;
}

PLAIT_END_NAMESPACE
