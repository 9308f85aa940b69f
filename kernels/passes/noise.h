// Noise that moves vertices: each coordinate by an amount that follows from a seed and from what
// digest() knows of the vertex. So the bits do not depend on threads, layouts and parts.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "passes/vertex_noise.h"
#include "plait/detail/namespace.h"
#include "plait/extend/topology.h"
#include "plait/extend/vector3.h"
#include "plait/vertex_rings.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Moves each coordinate by -length to +length, uniformly.
struct Noise {
  std::span<const Edge> edges;  ///< of the base mesh
  double length = 0;
  std::uint64_t seed = 0;

  /// Calls move(i, way) for each vertex of the run, which is a whole slot or base vertices: a visit
  /// without rings gives such runs.
  template <class Move>
  void for_each(const VertexRun& run, const Move& move) const {
    const auto way = [&](std::uint64_t key, std::uint64_t index) {
      const auto part = [&](unsigned axis) {
        return length * from_minus_one_to_one(random_word(key, 3 * index + axis));
      };
      return Vector3<double>{part(0), part(1), part(2)};
    };
    if (run.is_base()) {
      for (std::size_t i = 0; i < run.count; ++i) {
        const auto vertex = static_cast<VertexId>(run.first + i);
        move(i, way(slot_key(seed, vertex, vertex, run.level), 0));
      }
      return;
    }
    const Edge& edge = edges[run.edge];
    const std::uint64_t key = slot_key(seed, edge.start, edge.end, run.level);
    for (std::size_t i = 0; i < run.count; ++i) move(i, way(key, i));
  }
};

PLAIT_END_NAMESPACE
