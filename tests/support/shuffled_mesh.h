// support/shuffled_mesh.h: the same mesh with other numbers: vertices and faces in any order, and
// the corners of faces turned.
#pragma once

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <random>
#include <utility>
#include <vector>

#include "plait/base_mesh.h"

namespace plait::test {

/// `vertex_of` gets the former number of each vertex, if the caller wants it.
inline IndexedMesh shuffled(const IndexedMesh& mesh, unsigned seed,
                            std::vector<VertexId>* vertex_of = nullptr) {
  std::mt19937 random(seed);
  std::vector<VertexId> order(mesh.positions.size()), number(order.size());
  std::iota(order.begin(), order.end(), VertexId{0});
  std::shuffle(order.begin(), order.end(), random);
  IndexedMesh result;
  for (VertexId vertex = 0; vertex < order.size(); ++vertex) {
    number[order[vertex]] = vertex;
    result.positions.push_back(mesh.positions[order[vertex]]);
  }
  for (std::array<VertexId, 3> face : mesh.faces) {
    for (VertexId& vertex : face) vertex = number[vertex];
    std::rotate(face.begin(), face.begin() + random() % 3, face.end());
    result.faces.push_back(face);
  }
  std::shuffle(result.faces.begin(), result.faces.end(), random);
  if (vertex_of) *vertex_of = std::move(order);
  return result;
}

}  // namespace plait::test
