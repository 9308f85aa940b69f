// shapes.h: small named base meshes, and a check of the relations that every base mesh must
// satisfy.
#pragma once

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "plait/base_mesh.h"
#include "plait/error.h"

namespace plait::shapes {

using Faces = std::vector<std::array<VertexId, 3>>;

/// A mesh with positions that are all different, short as text and exact in float32. For tests of
/// connectivity and of files.
inline IndexedMesh with_any_positions(VertexId vertices, Faces faces) {
  IndexedMesh mesh;
  for (VertexId v = 0; v < vertices; ++v)
    mesh.positions.push_back({0.5 * (v % 128), -0.25 * (v / 128 % 128), 1.0 * (v / 16384)});
  mesh.faces = std::move(faces);
  return mesh;
}

/// The smallest closed mesh: valence 3 everywhere.
inline IndexedMesh tetrahedron() {
  return with_any_positions(4, {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {1, 3, 2}});
}

/// Valence 4 everywhere.
inline IndexedMesh octahedron() {
  return with_any_positions(
      6, {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 1}, {5, 2, 1}, {5, 3, 2}, {5, 4, 3}, {5, 1, 4}});
}

/// Valence 6 everywhere, genus 1. REQUIRES: both counts at least 3.
inline IndexedMesh torus(VertexId rows, VertexId columns) {
  Faces faces;
  for (VertexId r = 0; r < rows; ++r)
    for (VertexId c = 0; c < columns; ++c) {
      const VertexId down = (r + 1) % rows, right = (c + 1) % columns;
      faces.push_back({r * columns + c, down * columns + c, down * columns + right});
      faces.push_back({r * columns + c, down * columns + right, r * columns + right});
    }
  return with_any_positions(rows * columns, std::move(faces));
}

/// `spokes` faces around vertex 0 with a gap: one border loop.
inline IndexedMesh open_fan(VertexId spokes) {
  Faces faces;
  for (VertexId s = 1; s <= spokes; ++s) faces.push_back({0, s, s + 1});
  return with_any_positions(spokes + 2, std::move(faces));
}

/// A ring of vertices with two apices, 0 and 1, both of valence `ring`.
inline IndexedMesh double_cone(VertexId ring) {
  Faces faces;
  for (VertexId s = 0; s < ring; ++s) {
    const VertexId here = 2 + s, next = 2 + (s + 1) % ring;
    faces.push_back({0, here, next});
    faces.push_back({1, next, here});
  }
  return with_any_positions(2 + ring, std::move(faces));
}

/// A Moebius strip of `faces` triangles. REQUIRES: an odd number >= 5.
inline IndexedMesh moebius_strip(VertexId faces) {
  Faces strip;
  for (VertexId v = 0; v < faces; ++v) strip.push_back({v, (v + 1) % faces, (v + 2) % faces});
  return with_any_positions(faces, std::move(strip));
}

/// The message of the plait::Error that `call` throws with code kInvalidArgument.
template <class Call>
std::string refusal(Call&& call) {
  try {
    call();
  } catch (const Error& error) {
    CHECK(error.code() == ErrorCode::kInvalidArgument);
    return error.what();
  }
  FAIL("nothing was refused");
  return {};
}

/// Checks all promises of topology.h and base_mesh.h. Uses plain ifs and one REQUIRE per failure,
/// because millions of assertions would be slow on large meshes.
inline void check_topology(const BaseMesh& mesh) {
  const auto require = [](bool holds, const char* relation, std::uint64_t element) {
    if (holds) return;
    INFO(relation << ", element " << element);
    REQUIRE(false);
  };
  const Topology topology = mesh.topology();
  const auto faces = mesh.faces();
  const auto edges = mesh.edges();

  EdgeId numbered = 0;
  std::uint64_t border_sides = 0;
  for (FaceId face = 0; face < faces.size(); ++face)
    for (const int side : {2, 0, 1}) {
      const FaceSide here(face, side);
      const EdgeId id = mesh.face_edges()[face][static_cast<std::size_t>(side)];
      require(id < edges.size(), "edges exist", face);
      require(id <= numbered, "edges are numbered by first use", face);
      numbered = std::max(numbered, id + 1);
      const Edge& edge = edges[id];
      const VertexId start = faces[face][static_cast<std::size_t>((side + 1) % 3)];
      const VertexId end = faces[face][static_cast<std::size_t>((side + 2) % 3)];
      const bool own = edge.own == here;
      require(own || edge.other == here, "an edge knows its faces", id);
      require(edge.start == (own ? start : end) && edge.end == (own ? end : start),
              "an edge runs start to end in its own face, back in the other", id);
      if (!edge.is_border()) require(edge.start < edge.end, "own is low to high", id);
      require(topology.is_own(face, side) == own, "is_own", id);
      const FaceSide beyond = topology.across(here);
      require(beyond.exists() != edge.is_border(), "a border has nothing beyond", id);
      if (beyond.exists())
        require(beyond != here && topology.across(beyond) == here, "across is an involution", id);
      else
        ++border_sides;
    }
  require(numbered == edges.size(), "every edge is used", numbered);

  require(mesh.border_edge_count() == border_sides, "border edges are counted", border_sides);
  require(std::is_sorted(mesh.border_edges().begin(), mesh.border_edges().end()),
          "border edges ascend", 0);
  for (const EdgeId edge : mesh.border_edges())
    require(edges[edge].is_border(), "border edges are borders", edge);

  require(topology.vertex_corners.size() == mesh.vertex_count(), "a corner per vertex", 0);
  std::vector<char> reached(3 * faces.size(), 0);
  for (VertexId vertex = 0; vertex < mesh.vertex_count(); ++vertex) {
    const FaceSide first = topology.vertex_corners[vertex];
    require(first.exists(), "every vertex has a corner", vertex);
    const auto next_vertex = [&](FaceSide corner) {
      return faces[corner.face()][static_cast<std::size_t>((corner.side() + 1) % 3)];
    };
    VertexId smallest = next_vertex(first);
    FaceSide corner = first;
    do {
      require(!reached[corner.code], "a walk reaches a corner once", corner.code);
      reached[corner.code] = 1;
      require(faces[corner.face()][static_cast<std::size_t>(corner.side())] == vertex,
              "a walk stays at its vertex", vertex);
      smallest = std::min(smallest, next_vertex(corner));
      corner = topology.next_corner(corner);
    } while (corner.exists() && corner != first);
    const FaceSide spoke(first.face(), (first.side() + 2) % 3);
    if (corner.exists())
      require(next_vertex(first) == smallest, "a fan starts at the smallest neighbour", vertex);
    else
      require(!topology.across(spoke).exists(), "a border fan starts at the border", vertex);
  }
  require(std::count(reached.begin(), reached.end(), 1) == std::ssize(reached),
          "walks reach all corners", 0);
}

/// V - E + F.
inline std::int64_t euler_number(const BaseMesh& mesh) {
  return static_cast<std::int64_t>(mesh.vertex_count() + mesh.face_count()) -
         static_cast<std::int64_t>(mesh.edge_count());
}

}  // namespace plait::shapes
