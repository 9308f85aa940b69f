// render/patch_normal.h: computes normals for a store that has none.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "plait/extend/patch.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// [base vertex] the sum of the cross products of the base triangles around the vertex, at the
/// current positions of the base vertices; unit length.
template <class Real>
std::vector<Vector3<float>> base_vertex_normals(const Topology& mesh,
                                                std::span<const Vector3<Real>> positions) {
  std::vector<Vector3<double>> sums(positions.size());
  const auto at = [&](VertexId vertex) {
    const Vector3<Real>& p = positions[vertex];
    return Vector3<double>{p.x, p.y, p.z};
  };
  for (const auto& face : mesh.faces) {
    const Vector3<double> normal = cross(at(face[1]) - at(face[0]), at(face[2]) - at(face[0]));
    for (const VertexId vertex : face) sums[vertex] = sums[vertex] + normal;
  }
  std::vector<Vector3<float>> normals;
  normals.reserve(sums.size());
  for (const Vector3<double>& sum : sums) {
    const Vector3<double> unit = normalized(sum);
    normals.push_back(
        {static_cast<float>(unit.x), static_cast<float>(unit.y), static_cast<float>(unit.z)});
  }
  return normals;
}

/// The sum of the cross products of the (up to six) triangles around a vertex of a patch; unit
/// length. The vertex must not be a corner. Triangles on the other side of an edge count, so that
/// both patches give the same normal.
/// `level` counts from the store's base mesh; `size` is 2^level.
template <class Patch>
Vector3<float> patch_normal(const Patch& patch, int level, std::int64_t size, std::int64_t i,
                            std::int64_t j) {
  static constexpr std::array<std::array<std::int64_t, 2>, 6> kRing = {
      {{1, 0}, {0, 1}, {-1, 1}, {-1, 0}, {0, -1}, {1, -1}}};
  const int side = j == 0 ? 2 : i == 0 ? 1 : i + j == size ? 0 : -1;
  const bool border = side >= 0 && patch.is_border(side);
  const auto to_double = [](const auto& p) { return Vector3<double>{p.x, p.y, p.z}; };
  const auto exists = [&](std::size_t n) {
    const std::int64_t x = i + kRing[n][0], y = j + kRing[n][1];
    return !border || (x >= 0 && y >= 0 && x + y <= size);
  };
  const Vector3<double> centre = to_double(patch.at(level, i, j));
  Vector3<double> sum{};
  for (std::size_t n = 0; n < kRing.size(); ++n) {
    const std::size_t next = (n + 1) % kRing.size();
    if (!exists(n) || !exists(next)) continue;
    const Vector3<double> p = to_double(patch.at(level, i + kRing[n][0], j + kRing[n][1]));
    const Vector3<double> q = to_double(patch.at(level, i + kRing[next][0], j + kRing[next][1]));
    sum = sum + cross(p - centre, q - centre);
  }
  const Vector3<double> unit = normalized(sum);
  return {static_cast<float>(unit.x), static_cast<float>(unit.y), static_cast<float>(unit.z)};
}

PLAIT_END_NAMESPACE
