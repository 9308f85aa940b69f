// bench/peers/surfaces.h: the surfaces whose records plait and other libraries store, and their
// raw records.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "micro/command_line.h"
#include "peers/peer.h"
#include "plait/extend/backend.h"
#include "plait/layout.h"
#include "plait/reader.h"
#include "plait/store.h"

namespace plait::bench {

/// A store in memory with positions, and with normals unless they are not wanted. `name` is "exact"
/// for a Loop surface, or "noise", "fractal" or "noise, other normals" for one that is displaced.
/// Errors: as subdivide() and run_pass().
Store make_surface(const Settings& settings, const LaidOutMesh& mesh, const std::string& name,
                   bool normals);

/// Adds the records of the vertices that `level` creates, or those of the base mesh, in the order
/// of VertexNumbering (plait/extend/vertex_numbering.h).
inline void add_level(const Reader& reader, const std::string& attribute, int level, Points& to) {
  reader.for_each_block<Vector3<float>>(
      attribute, level, 0, reader.vertex_count(level),
      [&](std::uint64_t, std::span<const Vector3<float>> records) {
        to.insert(to.end(), records.begin(), records.end());
      });
}

/// The positions of all levels, in the order of VertexNumbering.
inline Points positions_of(const Store& store) {
  Points points;
  const Reader reader(store);
  for (int level = 0; level <= store.finest_level(); ++level)
    add_level(reader, "position", level, points);
  return points;
}

/// The raw positions and normals of all levels, and what filters must know of the surface. Refers
/// to its store.
struct RawSurface {
  LevelSurroundings surroundings;
  std::vector<std::vector<Points>> levels;  ///< [attribute][level - 1]

  explicit RawSurface(Store& store);
  std::span<const std::byte> bytes_of(const ContextBlock& block) const;

  int finest_level() const { return static_cast<int>(levels.front().size()); }
  const LevelGeometry& finest() const { return *surroundings.attributes.front().levels.back(); }
};

}  // namespace plait::bench
